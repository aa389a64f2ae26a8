"""The terminal UI: a headless session under thin Textual widgets."""

"""The state of the laboratory without its screen. Imports no Textual."""

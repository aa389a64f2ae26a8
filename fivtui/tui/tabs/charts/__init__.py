"""The charts of the tabs. Imports no Textual."""

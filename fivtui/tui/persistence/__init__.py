"""Saves and restores sessions. Imports no Textual."""

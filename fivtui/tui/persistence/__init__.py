"""The session between two starts. Imports no Textual."""

"""Parsers of the inputs of tabs; rows, texts and points of their results. Imports no Textual."""

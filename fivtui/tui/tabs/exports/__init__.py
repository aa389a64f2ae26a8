"""Exports of figures and data from the tabs. Imports no Textual."""

"""Requests from the inputs of tabs, and rows and points of their results. No Textual."""

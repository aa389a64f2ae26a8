"""The input form: editors, their rows, and the list of rows."""

"""The main screen of the laboratory."""

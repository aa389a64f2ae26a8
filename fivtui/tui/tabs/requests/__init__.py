"""What the inputs of tabs request, and the rows and points of their results. No Textual."""

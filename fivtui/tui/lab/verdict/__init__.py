"""The verdict above the tabs, and the gauge of safe and unsafe values below it."""

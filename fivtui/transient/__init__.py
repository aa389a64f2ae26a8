"""Transients: what is asked, the methods, the event loop, the result, its files and figure."""

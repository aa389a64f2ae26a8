"""Settings of a transient: their checks, and their table for files, form and command line."""

"""Console output: tables to stdout, progress to stderr."""

"""Benchmarks: figures to read, run by hand as modules."""

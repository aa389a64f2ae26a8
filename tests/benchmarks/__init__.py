"""Benchmarks: what this solver costs beside others, in one run on one machine."""

"""Sweeps: many transients as rows, in memory or in resumable files."""

"""Scenes: what to compute, by name, and its computation."""

"""Limit cycles and attractors: shooting, basins, continuation."""

"""Curves of limit cycles, stable and unstable, by pseudo-arclength continuation."""

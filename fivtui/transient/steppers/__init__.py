"""Integrators that are independent of the Taylor series: the paper's RK4, and those of SciPy."""

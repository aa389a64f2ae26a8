"""Stability of the equilibrium: eigenvalues, critical friction coefficients, maps."""

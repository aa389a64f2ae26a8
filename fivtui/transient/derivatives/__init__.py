"""Derivatives of transients by start and parameters, and how many digits they leave."""

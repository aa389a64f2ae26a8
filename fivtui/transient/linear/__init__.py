"""Exact solution of linear scenes by the matrix exponential."""

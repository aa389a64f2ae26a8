"""Curves of Hopf points, folds and touches over two parameters."""

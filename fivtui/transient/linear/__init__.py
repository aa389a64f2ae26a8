"""Linear scenes: solved exactly by the matrix exponential."""

"""The tabs of studies."""

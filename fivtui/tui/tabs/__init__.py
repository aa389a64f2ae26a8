"""The tabs of the laboratory."""

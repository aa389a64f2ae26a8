"""Many transients at once."""

"""Wheels, the source distribution and the release."""

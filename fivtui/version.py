"""The version of fivtui: its only source."""

__version__ = "1.0.0"

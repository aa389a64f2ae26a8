"""Tests of the identification of parameters."""

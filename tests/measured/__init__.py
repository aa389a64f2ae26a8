"""Tests of measured data."""

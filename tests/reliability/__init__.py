"""Tests of uncertainty studies."""

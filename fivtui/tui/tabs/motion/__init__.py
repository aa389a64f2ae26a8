"""Tabs and views of motions: the slider on the belt, branches of limit cycles, measured data."""

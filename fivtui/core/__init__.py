"""The slider-belt model and its numerics: numbers in, numbers out.

Nothing in this package reads, writes, prints, asks the time or knows a user interface.
"""

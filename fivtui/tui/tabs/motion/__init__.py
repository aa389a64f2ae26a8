"""Views of the transient tab: the slider on the belt, and measured data."""

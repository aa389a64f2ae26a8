"""The trade of speed for accuracy, measured."""

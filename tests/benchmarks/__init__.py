"""Benchmarks: what accuracy costs, beside other solvers, and how long a start takes.

``python -m tests.benchmarks`` prints the tables and draws the picture. Solvers of others are
compared where they can be imported; ``pip install '.[peers]'`` brings them.
"""

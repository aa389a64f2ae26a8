"""Benchmarks: what this solver costs beside others, in one run on one machine.

``python -m tests.benchmarks`` prints work and precision of single runs, and starts, and draws the
picture; the other modules are run by hand, such as ``python -m tests.benchmarks.batch``. Solvers of
others are compared where they can be imported; ``pip install '.[peers]'`` brings them.
"""

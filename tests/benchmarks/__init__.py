"""Benchmarks: CPU time of this solver, alone and compared with other solvers, on one machine.

``python -m tests.benchmarks`` prints work and precision of single runs beside other solvers, which
``pip install '.[peers]'`` brings, and draws them. ``python -m tests.benchmarks.speed`` compares two
checkouts; ``cluster`` and ``fmu_host`` beside it measure sweeps on a cluster and steps of the FMU.
"""

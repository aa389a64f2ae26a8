"""The limit cycles of a branch at a given value of the parameter."""

from itertools import pairwise

import numpy as np

from fivtui.model import OnProgress, Progress

from .cycle_branches import points_of
from .origins import cycle_near
from .result import CycleBranch, CyclePoint


def cycles_at(
    branch: CycleBranch, value: float, *, progress: OnProgress | None = None
) -> tuple[CyclePoint, ...]:
    """The limit cycles of a branch at a value of its parameter, in the order of the branch."""
    found: list[CyclePoint] = []
    work = Progress(progress)
    system = branch.system.with_values({branch.name: value})
    bounds = (branch.low, branch.high)
    for one, other in pairwise(branch.points):
        passed = (one.value - value) * (other.value - value) <= 0.0
        # A point at the value itself ends one pair and begins another.
        if not passed or one.value in (other.value, value):
            continue
        share = (value - one.value) / (other.value - one.value)
        begin, end = (np.array([*point.start, point.period]) for point in (one, other))
        x, vx, y, vy, period = (begin + share * (end - begin)).tolist()
        cycle = ((x, vx, y, vy), period)
        curve, orbit = cycle_near(system, branch.name, bounds, work, cycle)
        if orbit is not None:
            found += points_of(curve, [orbit])
    return tuple(found)

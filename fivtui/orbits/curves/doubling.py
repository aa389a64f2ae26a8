"""The branch of twice the period that begins at a period doubling."""

from typing import Final

import numpy as np

from .arclength import PERIOD, VALUE, OrbitOnCurve, directions_across
from .branch_curve import BranchCurve
from .events import EventKind
from .following import Follower

# Distances from the cycle, relative to its size, of guesses for a cycle of twice the period.
_DISTANCES: Final = (0.01, 0.003, 0.03, 0.1)
# Limit of points up to a period doubling, and first step.
_MOST_STEPS: Final = 20
_FIRST_STEP: Final = 1e-4
# Distance after half the period, relative to its size, below which a cycle repeats in it.
_RETURNS: Final = 3e-4


def doubled_cycle(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """A cycle of about twice the period next to a period doubling; None if none is found.

    Its tangent points away from the period doubling.
    """
    states = len(orbit.across)
    values, vectors = np.linalg.eig(orbit.monodromy)
    vector = vectors[:, np.abs(values + 1.0).argmin()].real
    direction = np.zeros(len(orbit.unknowns))
    direction[:states] = directions_across(orbit.across) @ vector
    direction /= np.linalg.norm(direction)
    size = float(np.abs(orbit.unknowns[:states]).max())
    for distance in _DISTANCES:
        guess = orbit.unknowns + distance * size * direction
        guess[PERIOD] *= 2.0
        planes = np.zeros((2, len(guess)))
        planes[0, :states], planes[1] = orbit.across, direction
        cycle = curve.orbits.solve(guess, planes)
        if cycle is not None and not halves(curve, cycle):
            return cycle
    return None


def halves(curve: BranchCurve, orbit: OrbitOnCurve) -> bool:
    """Whether an orbit is a cycle of half the period, followed twice."""
    return curve.orbits.returns_after(orbit, 0.5) < _RETURNS


def doubling_near(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """The period doubling next to an orbit of nearly twice the period; None without one.

    It is located on the branch of the single period, where the equations are not singular.
    """
    guess = orbit.unknowns.copy()
    guess[PERIOD] *= 0.5
    planes = np.zeros((2, len(guess)))
    planes[0, : len(orbit.across)], planes[1, VALUE] = orbit.across, 1.0
    start = curve.orbits.solve(guess, planes)
    if start is None:
        return None
    follower = Follower(curve, max_points=_MOST_STEPS)
    doublings = follower.events_both_ways(start, EventKind.PERIOD_DOUBLING, _FIRST_STEP)
    return min(
        doublings, key=lambda point: abs(float(point.unknowns[VALUE] - guess[VALUE])), default=None
    )

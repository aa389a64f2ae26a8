"""The branch of twice the period that begins where a limit cycle loses stability to it."""

from typing import Final

import numpy as np

from .arclength import PERIOD, VALUE, OrbitOnCurve, directions_across
from .branch_curve import BranchCurve
from .events import EventKind
from .following import Follower

# Distances from the cycle, relative to its size, at which one of twice the period is looked for.
_AWAY: Final = (0.01, 0.003, 0.03, 0.1)
# Steps within which a period doubling must be met, and the length of the first one.
_MOST_STEPS: Final = 20
_FIRST_STEP: Final = 1e-4
# A cycle is one of half the period, followed twice, if it returns that near after half of it.
_RETURNS: Final = 3e-4


def doubled_cycle(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """A cycle of about twice the period next to a period doubling; None if none is found.

    Its tangent leads away from there.
    """
    states = len(orbit.across)
    values, vectors = np.linalg.eig(orbit.monodromy)
    vector = vectors[:, np.abs(values + 1.0).argmin()].real
    direction = np.zeros(len(orbit.unknowns))
    direction[:states] = directions_across(orbit.across) @ vector
    direction /= np.linalg.norm(direction)
    size = float(np.abs(orbit.unknowns[:states]).max())
    for distance in _AWAY:
        guess = orbit.unknowns + distance * size * direction
        guess[PERIOD] *= 2.0
        planes = np.zeros((2, len(guess)))
        planes[0, :states], planes[1] = orbit.across, direction
        cycle = curve.orbits.solve(guess, planes)
        if cycle is not None and not halves(curve, cycle):
            return cycle
    return None


def halves(curve: BranchCurve, orbit: OrbitOnCurve) -> bool:
    """Whether an orbit is one of half the period, followed twice."""
    return curve.orbits.returns_after(orbit, 0.5) < _RETURNS


def doubling_near(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """The period doubling of the cycle that an orbit follows nearly twice; None if there is none.

    There the equations of the doubled cycle are singular, those of the cycle itself are not.
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

"""The branch of twice the period that begins where a limit cycle loses stability to it."""

from dataclasses import replace
from typing import Final

import numpy as np

from .arclength import PERIOD, VALUE, OrbitOnCurve
from .branch_curve import BranchCurve
from .events import End, EventKind
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
    place = int(np.abs(values + 1.0).argmin())
    # In the basis of `OrbitCurve`: the reflection that turns the first axis to the motion's.
    turn = orbit.across.copy()
    turn[0] += -1.0 if orbit.across[0] < 0.0 else 1.0
    basis = (np.eye(states) - np.outer(turn, 2.0 / (turn @ turn) * turn))[:, 1:]
    way = np.zeros(len(orbit.unknowns))
    way[:states] = basis @ vectors[:, place].real
    way /= np.linalg.norm(way)
    size = float(np.abs(orbit.unknowns[:states]).max())
    for distance in _AWAY:
        guess = orbit.unknowns + distance * size * way
        guess[PERIOD] *= 2.0
        planes = np.zeros((2, len(guess)))
        planes[0, :states], planes[1] = orbit.across, way
        found = curve.orbits.solve(guess, planes)
        if found is not None and not halves(curve, found):
            return found
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
    follower = Follower(curve, 0.0, lambda _count: None, most=_MOST_STEPS, turns=True)
    back = replace(start, tangent=-start.tangent, determinant=-start.determinant)
    parts = [
        follower.follow(one, step=_FIRST_STEP, until=EventKind.PERIOD_DOUBLING)
        for one in (start, back)
    ]
    found = [part.points[-1] for part in parts if part.end is End.EVENT]
    return min(found, key=lambda one: abs(float(one.unknowns[VALUE] - guess[VALUE])), default=None)

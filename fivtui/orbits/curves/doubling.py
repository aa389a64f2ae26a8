"""The branch of twice the period that begins at a period doubling.

There one multiplier of a cycle is -1: a deviation along its eigenvector recurs after two periods.
"""

from typing import Final

import numpy as np

from .arclength import PARAMETER, PERIOD, OrbitOnCurve, normal_basis
from .branch_curve import BranchCurve
from .events import EventKind
from .following import Follower

# Distances from the cycle, relative to its size, of guesses for a cycle of twice the period, in the
# order in which they are tried.
_DISTANCES: Final = (0.01, 0.003, 0.03, 0.1)
# Greatest number of points up to a period doubling, and length of the first step.
_MAX_DOUBLING_POINTS: Final = 20
_FIRST_STEP: Final = 1e-4
# A cycle repeats one of half the period if its state after half the period differs from the start
# by less than this, relative to the size of the state.
_HALF_PERIOD_DISTANCE: Final = 3e-4


def doubled_cycle(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """The cycle of about twice the period next to a period doubling; None if it is not found.

    Its tangent points away from the period doubling, along the deviation that begins there.
    """
    state_count = len(orbit.flow_direction)
    values, vectors = np.linalg.eig(orbit.monodromy)
    # The eigenvector of the multiplier -1, in the basis of the plane normal to the flow.
    eigenvector = vectors[:, np.abs(values + 1.0).argmin()].real
    direction = np.zeros(len(orbit.unknowns))
    direction[:state_count] = normal_basis(orbit.flow_direction) @ eigenvector
    direction /= np.linalg.norm(direction)
    size = float(np.abs(orbit.unknowns[:state_count]).max())
    for distance in _DISTANCES:
        guess = orbit.unknowns + distance * size * direction
        guess[PERIOD] *= 2.0
        # The first plane fixes the phase, the second the distance; its normal directs the tangent.
        plane_normals = np.zeros((2, len(guess)))
        plane_normals[0, :state_count], plane_normals[1] = orbit.flow_direction, direction
        cycle = curve.orbits.solve(guess, plane_normals)
        if cycle is not None and not has_half_period(curve, cycle):
            return cycle
    return None


def has_half_period(curve: BranchCurve, orbit: OrbitOnCurve) -> bool:
    """Whether an orbit repeats a cycle of half the period."""
    return curve.orbits.return_distance(orbit, share=0.5) < _HALF_PERIOD_DISTANCE


def locate_doubling(curve: BranchCurve, orbit: OrbitOnCurve) -> OrbitOnCurve | None:
    """The period doubling next to an orbit of nearly twice the period; None if it is not found.

    It is located on the branch of the single period, where the equations are not singular.
    """
    guess = orbit.unknowns.copy()
    guess[PERIOD] *= 0.5
    # The first plane fixes the phase, the second the parameter.
    plane_normals = np.zeros((2, len(guess)))
    plane_normals[0, : len(orbit.flow_direction)] = orbit.flow_direction
    plane_normals[1, PARAMETER] = 1.0
    start = curve.orbits.solve(guess, plane_normals)
    if start is None:
        return None
    follower = Follower(curve, max_points=_MAX_DOUBLING_POINTS)
    doublings = follower.events_both_ways(start, EventKind.PERIOD_DOUBLING, _FIRST_STEP)
    return min(
        doublings, key=lambda p: abs(float(p.unknowns[PARAMETER] - guess[PARAMETER])), default=None
    )

"""Folds of limit cycles along μ: taken from a branch, and continued to parameter sets nearby.

Each parameter set has units of its own, so that scaled folds change little between sets.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import System, accelerations, mode_of
from fivtui.orbits.curves.arclength import VALUE, OrbitCurve, OrbitOnCurve, cycle_scales
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, SliderBeltFlow
from fivtui.orbits.curves.result import CycleBranch, CyclePoint, event_at
from fivtui.orbits.rest import length_scale, slowest_period

_MU: Final = "mu"
_MOST_STEPS: Final = 40
# Longest step along the curve, relative to the amplitude, and the first step, which measures the
# bend.
_LONGEST: Final = 0.5
_PROBE: Final = 0.05
# Least cosine between the motion and the normal of the plane; below it the phase condition fails.
_TRANSVERSE: Final = 0.5
# Step at which the search has converged, and largest distance of a multiplier from 1 at a fold.
_SHORT: Final = 3e-6
_UNITY: Final = 1e-2
# Bend, times the square of the amplitude, above which it may be rounding. It is then measured again
# from slopes at this distance on both sides, relative to the amplitude.
_SHARP: Final = 1.0
_BESIDE: Final = 0.01
# Least distance between two slopes for a new bend, relative to the amplitude.
_SLOPE_DISTANCE: Final = 1e-6
# Next to the first touch of y = 0 the slope changes quickly. Steps keep this margin from the ends
# of the bracket, down to a bracket of this length.
_INSIDE: Final = 0.05
_CLOSE: Final = 1e-12
_SADDLE: Final = 2.0
# Size, relative to the length, below which a cycle is the equilibrium.
_SMALLEST: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOrbit:
    """A limit cycle at a fold where μ has a minimum along the branch."""

    mu: float
    half_range: float
    amplitude: float
    unknowns: FloatArray
    across: FloatArray
    tangent: FloatArray
    bend: float


def folds_of(branch: CycleBranch) -> list[FoldOrbit]:
    """The folds of a branch along μ above which cycles attract, see `fold_near`."""
    folds = []
    units = _units(branch.system)
    for before, point, after in zip(
        branch.points, branch.points[1:], branch.points[2:], strict=False
    ):
        if event_at(branch, point) is not EventKind.FOLD:
            continue
        tangent = _unknowns(after) / units - _unknowns(before) / units
        p, state = branch.parameters.with_values({_MU: point.value}), point.start
        ax, ay = accelerations(p, state, mode_of(p, state, separation=branch.separation))
        across = np.array([state[1], ax, state[3], ay]) / units[:4]
        start = FoldOrbit(
            mu=point.value,
            half_range=point.half_range,
            amplitude=point.half_range / float(units[0]),
            unknowns=_unknowns(point) / units,
            across=across / np.linalg.norm(across),
            tangent=tangent / np.linalg.norm(tangent),
            bend=0.0,
        )
        fold = fold_near(branch.system, start)
        if fold is not None:
            folds.append(fold)
    return folds


def fold_near(
    system: System,
    guess: FoldOrbit,
    unknowns: FloatArray | None = None,
) -> FoldOrbit | None:
    """The fold of a system near the fold of a similar system."""
    flow, units = SliderBeltFlow(system, (_MU,)), _units(system)
    curve = OrbitCurve(flow, units)
    base = guess.unknowns if unknowns is None else unknowns
    planes = np.zeros((2, len(base)))
    planes[0, :4], planes[1] = guess.across, guess.tangent

    def orbit_at(distance: float) -> OrbitOnCurve | None:
        return curve.solve(base + distance * guess.tangent, planes)

    bend, distance, size = guess.bend, 0.0, guess.amplitude
    # Distances along the first tangent: the previous one with its slope, and the bracket.
    previous: tuple[float, float] | None = None
    sides: dict[bool, float] = {}
    for _ in range(_MOST_STEPS):
        orbit = orbit_at(distance)
        if orbit is None or float(orbit.across @ guess.across) < _TRANSVERSE:
            return None
        slope = float(orbit.tangent[VALUE])
        if previous is not None and abs(distance - previous[0]) > _SLOPE_DISTANCE * size:
            bend = (slope - previous[1]) / (distance - previous[0])
        previous, sides[slope > 0.0] = (distance, slope), distance
        step = -slope / bend if bend != 0.0 else _PROBE * size
        if bend != 0.0 and abs(step) < _SHORT * size:
            if bend * size * size > _SHARP:
                bend = _bend_beside(orbit_at, distance, _BESIDE * size)
            return _fold(orbit, bend, float(units[0]))
        distance += max(min(step, _LONGEST * size), -_LONGEST * size)
        if len(sides) == 2:
            low, high = sorted(sides.values())
            margin = _INSIDE * (high - low)
            if not low + margin < distance < high - margin:
                distance = 0.5 * (low + high)
            if high - low < _CLOSE * size:
                return None
    return None


def _bend_beside(
    orbit_at: Callable[[float], OrbitOnCurve | None], at: float, distance: float
) -> float:
    # The bend by the slopes on both sides; NaN unless the parameter has a minimum in between.
    orbits = (orbit_at(at - distance), orbit_at(at + distance))
    before, after = (0.0 if orbit is None else float(orbit.tangent[VALUE]) for orbit in orbits)
    return (after - before) / (2.0 * distance) if before < 0.0 < after else math.nan


def _fold(orbit: OrbitOnCurve, bend: float, length: float) -> FoldOrbit | None:
    low, high = orbit.extremes[2:4].tolist()
    size = 0.5 * (high - low) / length
    multipliers = orbit.multipliers
    unity = int(np.abs(multipliers - 1.0).argmin())
    remaining = np.delete(multipliers, unity)
    # A real multiplier slightly above 1 is next to a torus, beyond which cycles attract.
    saddle = bool(np.any((remaining.imag == 0.0) & (remaining.real > _SADDLE)))
    if not bend >= 0.0 or size < _SMALLEST or saddle or abs(multipliers[unity] - 1.0) > _UNITY:
        return None
    return FoldOrbit(
        float(orbit.unknowns[VALUE]),
        0.5 * (high - low),
        size,
        orbit.unknowns,
        orbit.across,
        orbit.tangent,
        bend,
    )


def _unknowns(point: CyclePoint) -> FloatArray:
    return np.array([*point.start, point.period, point.value])


def _units(system: System) -> FloatArray:
    # The length is that of the contact spring, if cubic: motions of equal F² k_nl scale with it.
    p = system.parameters
    length = math.sqrt(p.k2 / p.k_nl) if p.k_nl > 0.0 else length_scale(system)
    return cycle_scales(length, slowest_period(p), 1.0)

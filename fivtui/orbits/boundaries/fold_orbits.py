"""Folds of limit cycles along μ: located on a branch, and continued to parameter sets nearby.

The units depend on the parameter set, so that scaled folds change little between sets.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import System, accelerations, mode_of
from fivtui.orbits.curves.arclength import PARAMETER, OrbitCurve, OrbitOnCurve, cycle_scales
from fivtui.orbits.curves.events import EventKind
from fivtui.orbits.curves.flow import FloatArray, SliderBeltFlow
from fivtui.orbits.curves.result import CycleBranch, CyclePoint, event_at
from fivtui.orbits.rest import length_scale, slowest_period

_MU: Final = "mu"
_MAX_ITERATIONS: Final = 40
# Longest step and first step along the curve, relative to the amplitude.
_MAX_STEP: Final = 0.5
_FIRST_STEP: Final = 0.05
# Least cosine between the motion and the normal of the phase plane.
_MIN_COSINE: Final = 0.5
# Step, relative to the amplitude, of a converged search; distance of a fold's multiplier from 1.
_CONVERGED: Final = 3e-6
_TOL: Final = 1e-2
# Curvature, times the square of the amplitude, above which it may be rounding. It is then computed
# from slopes at this distance on both sides, relative to the amplitude.
_DOUBTFUL_CURVATURE: Final = 1.0
_SIDE_DISTANCE: Final = 0.01
# Least distance between two slopes for a new curvature, relative to the amplitude.
_SLOPE_DISTANCE: Final = 1e-6
# Next to the first touch of y = 0 the slope changes quickly. Steps keep this margin from the ends
# of the bracket, and the search fails at a bracket of this length.
_BRACKET_MARGIN: Final = 0.05
_MIN_BRACKET: Final = 1e-12
# Real multiplier above which the cycles beyond the fold are unstable as well.
_SADDLE_MULTIPLIER: Final = 2.0
# Size, relative to the length, below which a cycle is the equilibrium.
_MIN_SIZE: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOrbit:
    """A limit cycle at a fold where μ has a minimum; `curvature` is that of μ along the branch."""

    mu: float
    half_range: float
    amplitude: float
    unknowns: FloatArray
    flow_direction: FloatArray
    tangent: FloatArray
    curvature: float


def stabilising_folds(branch: CycleBranch) -> list[FoldOrbit]:
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
        flow_direction = np.array([state[1], ax, state[3], ay]) / units[:4]
        start = FoldOrbit(
            mu=point.value,
            half_range=point.half_range,
            amplitude=point.half_range / float(units[0]),
            unknowns=_unknowns(point) / units,
            flow_direction=flow_direction / np.linalg.norm(flow_direction),
            tangent=tangent / np.linalg.norm(tangent),
            curvature=0.0,
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
    """The fold of a system near that of a similar system; `unknowns` replace those of `guess`."""
    flow, units = SliderBeltFlow(system, (_MU,)), _units(system)
    curve = OrbitCurve(flow, units)
    start = guess.unknowns if unknowns is None else unknowns
    planes = np.zeros((2, len(start)))
    planes[0, :4], planes[1] = guess.flow_direction, guess.tangent

    def orbit_at(distance: float) -> OrbitOnCurve | None:
        return curve.solve(start + distance * guess.tangent, planes)

    curvature, distance, size = guess.curvature, 0.0, guess.amplitude
    # Distances along the guess's tangent: the last one with its slope, and the bracket by sign.
    previous: tuple[float, float] | None = None
    bracket: dict[bool, float] = {}
    for _ in range(_MAX_ITERATIONS):
        orbit = orbit_at(distance)
        if orbit is None or float(orbit.flow_direction @ guess.flow_direction) < _MIN_COSINE:
            return None
        slope = float(orbit.tangent[PARAMETER])
        if previous is not None and abs(distance - previous[0]) > _SLOPE_DISTANCE * size:
            curvature = (slope - previous[1]) / (distance - previous[0])
        previous, bracket[slope > 0.0] = (distance, slope), distance
        step = -slope / curvature if curvature != 0.0 else _FIRST_STEP * size
        if curvature != 0.0 and abs(step) < _CONVERGED * size:
            if curvature * size * size > _DOUBTFUL_CURVATURE:
                curvature = _curvature_from_sides(orbit_at, distance, _SIDE_DISTANCE * size)
            return _validate_fold(orbit, curvature, float(units[0]))
        distance += max(min(step, _MAX_STEP * size), -_MAX_STEP * size)
        if len(bracket) == 2:
            low, high = sorted(bracket.values())
            margin = _BRACKET_MARGIN * (high - low)
            if not low + margin < distance < high - margin:
                distance = 0.5 * (low + high)
            if high - low < _MIN_BRACKET * size:
                return None
    return None


def _curvature_from_sides(
    orbit_at: Callable[[float], OrbitOnCurve | None], centre: float, distance: float
) -> float:
    # The curvature by slopes on both sides; NaN unless the parameter has a minimum in between.
    orbits = (orbit_at(centre - distance), orbit_at(centre + distance))
    before, after = (0.0 if orbit is None else float(orbit.tangent[PARAMETER]) for orbit in orbits)
    return (after - before) / (2.0 * distance) if before < 0.0 < after else math.nan


def _validate_fold(orbit: OrbitOnCurve, curvature: float, length: float) -> FoldOrbit | None:
    low, high = orbit.extremes[2:4].tolist()
    size = 0.5 * (high - low) / length
    multipliers = orbit.multipliers
    unit = int(np.abs(multipliers - 1.0).argmin())
    remaining = np.delete(multipliers, unit)
    # A real multiplier slightly above 1 occurs next to a torus, beyond which cycles attract.
    saddle = bool(np.any((remaining.imag == 0.0) & (remaining.real > _SADDLE_MULTIPLIER)))
    if not curvature >= 0.0 or size < _MIN_SIZE or saddle or abs(multipliers[unit] - 1.0) > _TOL:
        return None
    return FoldOrbit(
        float(orbit.unknowns[PARAMETER]),
        0.5 * (high - low),
        size,
        orbit.unknowns,
        orbit.flow_direction,
        orbit.tangent,
        curvature,
    )


def _unknowns(point: CyclePoint) -> FloatArray:
    return np.array([*point.start, point.period, point.value])


def _units(system: System) -> FloatArray:
    # The unit of length is that of a cubic contact spring: motions of equal F² k_nl scale with it.
    p = system.parameters
    length = math.sqrt(p.k2 / p.k_nl) if p.k_nl > 0.0 else length_scale(system)
    return cycle_scales(length, slowest_period(p), 1.0)

"""Folds of limit cycles along μ at which μ has a minimum.

Those of a branch are found, and each is followed to a system with slightly different parameters.

The unknowns of an orbit are its state, its period and μ. Their units depend on the parameter set,
so that scaled folds change little between sets.
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
_STATE: Final = slice(0, 4)
# Upper bound; Newton's method converges in a few iterations.
_MAX_ITERATIONS: Final = 40
# Longest step and first step along the curve, relative to the amplitude.
_MAX_STEP: Final = 0.5
_FIRST_STEP: Final = 0.05
# Least cosine between the motion at an orbit's start and that at the guess, which is the normal of
# the plane that fixes the phase.
_MIN_COSINE: Final = 0.5
# Step, relative to the amplitude, below which the search has converged.
_CONVERGED_STEP: Final = 3e-6
# Greatest distance from 1 of the multiplier that is 1 at a fold.
_UNIT_TOLERANCE: Final = 1e-2
# Curvature, times the square of the amplitude, above which it may be rounding: a difference of
# close slopes, divided by a small distance. It is then computed from slopes at this distance on
# both sides, relative to the amplitude.
_DOUBTFUL_CURVATURE: Final = 1.0
_SIDE_DISTANCE: Final = 0.01
# Least distance between two slopes for a new curvature, relative to the amplitude.
_SLOPE_DISTANCE: Final = 1e-6
# Where cycles begin to leave the belt, at y = 0, the slope changes quickly. Steps keep this margin
# from the ends of the bracket, relative to its length. The search fails once the bracket is shorter
# than this part of the amplitude.
_BRACKET_MARGIN: Final = 0.05
_MIN_BRACKET: Final = 1e-12
# Real multiplier above which the cycles beyond the fold are unstable as well. One slightly above 1
# occurs next to a torus bifurcation, where a pair of multipliers crosses the unit circle: beyond it
# cycles attract.
_SADDLE_MULTIPLIER: Final = 2.0
# Amplitude, relative to the unit of length, below which a cycle is the equilibrium.
_MIN_AMPLITUDE: Final = 1e-4


@dataclass(frozen=True, slots=True)
class FoldOrbit:
    """A limit cycle at a fold where μ has a minimum along the branch.

    `half_range` is half peak-to-peak of y, m, and `amplitude` the same in units of length. The
    vectors are scaled; `flow_direction` and `tangent` are the unit vectors along the orbit and
    along the branch. `curvature` is the second derivative of μ along the branch.
    """

    mu: float
    half_range: float
    amplitude: float
    unknowns: FloatArray
    flow_direction: FloatArray
    tangent: FloatArray
    curvature: float


def stabilising_folds(branch: CycleBranch) -> list[FoldOrbit]:
    """The folds of a branch along μ that are minima of μ, and beyond which cycles attract."""
    folds = []
    units = _units(branch.system)
    length = float(units[0])
    for before, point, after in zip(
        branch.points, branch.points[1:], branch.points[2:], strict=False
    ):
        if event_at(branch, point) is not EventKind.FOLD:
            continue
        tangent = _unknowns(after) / units - _unknowns(before) / units
        p, state = branch.parameters.with_values({_MU: point.value}), point.start
        _, vx, _, vy = state
        ax, ay = accelerations(p, state, mode_of(p, state, separation=branch.separation))
        flow_direction = np.array([vx, ax, vy, ay]) / units[_STATE]
        guess = FoldOrbit(
            mu=point.value,
            half_range=point.half_range,
            amplitude=point.half_range / length,
            unknowns=_unknowns(point) / units,
            flow_direction=flow_direction / np.linalg.norm(flow_direction),
            tangent=tangent / np.linalg.norm(tangent),
            curvature=0.0,
        )
        fold = fold_near(branch.system, guess)
        if fold is not None:
            folds.append(fold)
    return folds


def fold_near(
    system: System,
    guess: FoldOrbit,
    unknowns: FloatArray | None = None,
) -> FoldOrbit | None:
    """The fold of a system near that of a similar system; `unknowns` replace those of `guess`.

    Newton's method finds the zero of the slope of μ along the guess's tangent.
    """
    flow, units = SliderBeltFlow(system, (_MU,)), _units(system)
    curve = OrbitCurve(flow, units)
    origin = guess.unknowns if unknowns is None else unknowns
    normals = np.zeros((2, len(origin)))
    # One plane fixes the phase, the other the distance along the tangent.
    normals[0, _STATE] = guess.flow_direction
    normals[1] = guess.tangent

    def orbit_at(distance: float) -> OrbitOnCurve | None:
        return curve.solve(origin + distance * guess.tangent, normals)

    curvature, distance, amplitude = guess.curvature, 0.0, guess.amplitude
    previous_distance, previous_slope = distance, 0.0
    # The latest distance at which μ rises (key True), and at which it does not.
    latest_distances: dict[bool, float] = {}
    for _ in range(_MAX_ITERATIONS):
        orbit = orbit_at(distance)
        if orbit is None or float(orbit.flow_direction @ guess.flow_direction) < _MIN_COSINE:
            return None
        slope = float(orbit.tangent[PARAMETER])
        if abs(distance - previous_distance) > _SLOPE_DISTANCE * amplitude:
            curvature = (slope - previous_slope) / (distance - previous_distance)
        previous_distance, previous_slope = distance, slope
        latest_distances[slope > 0.0] = distance
        step = -slope / curvature if curvature != 0.0 else _FIRST_STEP * amplitude
        if curvature != 0.0 and abs(step) < _CONVERGED_STEP * amplitude:
            if curvature * amplitude * amplitude > _DOUBTFUL_CURVATURE:
                curvature = _curvature_from_sides(orbit_at, distance, _SIDE_DISTANCE * amplitude)
            return _validate_fold(orbit, curvature, float(units[0]))
        distance += max(min(step, _MAX_STEP * amplitude), -_MAX_STEP * amplitude)
        if len(latest_distances) == 2:
            # Slopes of both signs bracket the zero.
            low, high = sorted(latest_distances.values())
            margin = _BRACKET_MARGIN * (high - low)
            if not low + margin < distance < high - margin:
                distance = 0.5 * (low + high)
            if high - low < _MIN_BRACKET * amplitude:
                return None
    return None


def _curvature_from_sides(
    orbit_at: Callable[[float], OrbitOnCurve | None], centre: float, distance: float
) -> float:
    # The curvature by slopes on both sides; NaN unless μ has a minimum in between.
    orbits = (orbit_at(centre - distance), orbit_at(centre + distance))
    before, after = (0.0 if orbit is None else float(orbit.tangent[PARAMETER]) for orbit in orbits)
    return (after - before) / (2.0 * distance) if before < 0.0 < after else math.nan


def _validate_fold(orbit: OrbitOnCurve, curvature: float, length: float) -> FoldOrbit | None:
    # The fold at an orbit; None if μ has no minimum there, cycles beyond it are unstable, the orbit
    # is the equilibrium, or no multiplier is 1.
    half_range = 0.5 * (orbit.y_max - orbit.y_min)
    amplitude = half_range / length
    multipliers = orbit.multipliers
    unit_index = int(np.abs(multipliers - 1.0).argmin())
    remaining = np.delete(multipliers, unit_index)
    is_saddle = bool(np.any((remaining.imag == 0.0) & (remaining.real > _SADDLE_MULTIPLIER)))
    if not curvature >= 0.0 or amplitude < _MIN_AMPLITUDE or is_saddle:
        return None
    if abs(multipliers[unit_index] - 1.0) > _UNIT_TOLERANCE:
        return None
    return FoldOrbit(
        mu=float(orbit.unknowns[PARAMETER]),
        half_range=half_range,
        amplitude=amplitude,
        unknowns=orbit.unknowns,
        flow_direction=orbit.flow_direction,
        tangent=orbit.tangent,
        curvature=curvature,
    )


def _unknowns(point: CyclePoint) -> FloatArray:
    # The unknowns of a cycle, in SI units.
    return np.array([*point.start, point.period, point.value])


def _units(system: System) -> FloatArray:
    # Units of the unknowns. The unit of length is that of the cubic contact spring, at which its
    # force equals the linear one. The scaled preload is then F √(k_nl/k2³): sets that differ only
    # in F and k_nl have the same scaled motions if F² k_nl is equal.
    p = system.parameters
    length = math.sqrt(p.k2 / p.k_nl) if p.k_nl > 0.0 else length_scale(system)
    return cycle_scales(length, slowest_period(p), 1.0)

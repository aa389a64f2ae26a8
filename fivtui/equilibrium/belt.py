"""Stability of sliding on a belt of finite speed, where friction depends on the speed.

Stability follows from the Jacobian at the equilibrium by the Routh–Hurwitz criterion. Its last
determinant is a smooth function of the friction coefficient and of the belt speed; stability
changes at its zeros. A grid, refined where the determinant comes near zero, brackets the zeros, and
Brent's method locates them. Values and slopes of the friction law come from `fivtui.model`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    MODES,
    PARAMETERS,
    Mode,
    Parameters,
    System,
    check_has_verdict,
    check_off_edge,
    depends_on_speed,
    friction_coefficient,
    jacobian,
    load,
    parameter_spec,
    resting_height,
    sliding_friction_ratio,
    sliding_mode,
)

from .critical import Becomes, CriticalMu, critical_mu as constant_critical_mu
from .heights import resting_heights

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Intervals over the friction coefficient.
_MU_INTERVALS: Final = 128
# Number of parts of a refined interval, and of levels of refinement: near zeros of the determinant,
# and where the other conditions of stability begin or cease to hold.
_REFINEMENT: Final = 16
_MAX_LEVEL: Final = 8
_MAX_CONDITION_LEVEL: Final = 2
# Where the determinant touches zero between two points of the grid, both may have the same size.
# But two points from the smaller one its size is greater by this factor at least.
_RISE_FACTOR: Final = 2.0
# Determinant, relative to its terms, that is zero to rounding.
_ROUNDING: Final = 2.0**-50


class _ArrayWithExp(np.ndarray[Any, Any]):
    # Values of μ or of the belt speed. The friction law calls the method `exp` of every number that
    # is not a float or complex; arrays of NumPy have none.

    def exp(self) -> Any:
        return np.exp(np.asarray(self))


@dataclass(frozen=True, slots=True)
class CriticalSpeed:
    """A speed of the belt, m/s, at which stability changes.

    `becomes` says what sliding becomes on faster belts that run in the same direction.
    """

    v_belt: float
    becomes: Becomes


def critical_mu_on_belt(system: System) -> tuple[CriticalMu, ...]:
    """Every μ > 0, at most `mu_s`, at which the stability of sliding changes, ascending.

    Two changes are omitted if rounding hides the interval between them. Raises
    `ComputationError` on a belt at rest, and at F = 0 with separation.
    """
    check_has_verdict(system)
    p = system.parameters
    # If friction depends on the speed at any μ, it does so at μ = 0, where it falls most.
    if p.v_belt is None or not depends_on_speed(p.replaced(mu=0.0)):
        return constant_critical_mu(system)
    # No μ is critical without sliding: F < 0 lifts the slider off the belt.
    if system.separation and load(p) < 0.0:
        return ()
    mu_max = PARAMETERS["mu"].upper if p.mu_s is None else p.mu_s
    # Chebyshev points, which are dense at both ends.
    grid = 0.5 * mu_max * (1.0 - np.cos(np.linspace(0.0, np.pi, _MU_INTERVALS + 1)))
    grid[-1] = mu_max
    return tuple(CriticalMu(mu, becomes) for mu, becomes in _stability_changes(p, "mu", grid))


def critical_speeds(system: System) -> tuple[CriticalSpeed, ...]:
    """Every belt speed, in the direction of `v_belt`, at which the stability of sliding changes.

    They are listed from slow to fast belts. Two changes are omitted if rounding hides the interval
    between them. Raises `ComputationError` at F = 0 with separation.
    """
    check_off_edge(system)
    p, lifted = system.parameters, system.separation and load(system.parameters) < 0.0
    if p.v_belt is None or lifted or not depends_on_speed(p):
        return ()
    speed_max = parameter_spec("v_belt").upper
    grid = (p.v_s or 1.0) * _relative_speeds()
    grid = np.append(grid[grid < speed_max], speed_max)
    changes = _stability_changes(p, "v_belt", np.copysign(grid, p.v_belt))
    changes.sort(key=lambda change: abs(change[0]))
    return tuple(CriticalSpeed(v, becomes) for v, becomes in changes)


@cache
def _relative_speeds() -> FloatArray:
    # Speeds relative to the scale of the friction law: evenly spaced, then in a constant ratio.
    parts = (
        np.array([0.0, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2]),
        np.arange(0.25, 64.0, 0.25),
        np.geomspace(64.0, 1e3, 256, endpoint=False),
        np.geomspace(1e3, 1e21, 160),
    )
    return np.concatenate(parts)


def _stability_changes(p: Parameters, name: str, grid: FloatArray) -> list[tuple[float, Becomes]]:
    # Values of a parameter at which stability changes, and the stability beyond each. The margin of
    # stability is the determinant, made negative where another condition fails.
    mode = sliding_mode(p)

    def margins_at(values: FloatArray) -> tuple[FloatArray, BoolArray]:
        varied: Any = p.replaced(**{name: values.view(_ArrayWithExp)})
        with np.errstate(all="ignore"):
            mu = np.asarray(friction_coefficient(varied, abs(varied.v_belt)))
            heights = resting_heights(varied, MODES[mode].friction_sign * mu)
            determinant, size, conditions_hold = _hurwitz(varied, heights, mode)
        margin = np.where(conditions_hold, determinant, -np.abs(determinant))
        return np.where(np.abs(determinant) > _ROUNDING * size, margin, np.nan), conditions_hold

    def margin_at(value: float) -> float:
        varied = p.replaced(**{name: value})
        # In contact, as `resting_heights` assumes: callers exclude a slider that is lifted off.
        in_contact = System(varied, separation=False)
        height = resting_height(in_contact, sliding_friction_ratio(varied))
        determinant, _, conditions_hold = _hurwitz(varied, height, mode)
        return float(determinant if conditions_hold else -abs(determinant))

    return [
        (_locate_zero(margin_at, low, high), "stable" if stable else "unstable")
        for low, high, stable in _find_brackets(margins_at, grid)
    ]


def _hurwitz(p: Parameters, y: Any, mode: Mode) -> tuple[Any, Any, Any]:
    # The last Hurwitz determinant of the equilibrium at y, the sum of the sizes of its terms, and
    # whether the other conditions of stability hold. The characteristic polynomial is
    # (λ² + c1 λ + a) (λ² + c2 λ + b) − d. For c2 = 0 its determinant is c1² d: divided by c1 + c2,
    # it changes sign with c1.
    _, (xx, xvx, xy, _), _, (yx, _, yy, yvy) = jacobian(p, y, mode)
    a, c1, b, c2, d = -xx, -xvx, -yy, -yvy, xy * yx
    cubic, linear = c1 + c2, c1 * b + c2 * a
    terms = c1 * c2 * ((a - b) * (a - b)), c1 * c2 * (cubic * linear), cubic * cubic * d
    conditions_hold = (cubic > 0.0) & (linear > 0.0) & (a * b > d)
    scale = abs(cubic) + (cubic == 0.0)
    return sum(terms) / scale, sum(map(abs, terms)) / scale, conditions_hold


def _find_brackets(
    margins_at: Callable[[FloatArray], tuple[FloatArray, BoolArray]],
    grid: FloatArray,
    level: int = 0,
) -> list[tuple[float, float, bool]]:
    # Brackets of single sign changes of the stability margin, ascending, and whether it is positive
    # above. Ranges that may hide two changes are refined: where the margin nearly touches zero,
    # where the other conditions begin or cease to hold, and around changes on the first grid.
    margins, conditions_hold = margins_at(grid)
    resolved = ~np.isnan(margins)
    if not resolved.any():
        return []
    grid, margins, conditions_hold = grid[resolved], margins[resolved], conditions_hold[resolved]
    stable = margins > 0.0
    changes = np.flatnonzero(stable[1:] != stable[:-1]).tolist()
    ranges = [(n - 1, n + 2) for n in changes] if level == 0 else []
    if level < _MAX_LEVEL:
        ranges += [(n - 1, n + 1) for n in _near_zero_indices(margins, conditions_hold)]
    if level < _MAX_CONDITION_LEVEL:
        # Where the other conditions begin or cease to hold, a short range of stability may hide,
        # unless a stable point beside it reveals it.
        begin_indices = np.flatnonzero(conditions_hold[1:] > conditions_hold[:-1]).tolist()
        end_indices = np.flatnonzero(conditions_hold[1:] < conditions_hold[:-1]).tolist()
        ranges += [(n, n + 1) for n in begin_indices if not stable[n + 1 : n + 3].any()]
        ranges += [(n, n + 1) for n in end_indices if not stable[max(n - 1, 0) : n + 1].any()]
    ranges = _merge_ranges([(max(low, 0), min(high, grid.size - 1)) for low, high in ranges])
    brackets = [
        (float(grid[n]), float(grid[n + 1]), bool(stable[n + 1]))
        for n in changes
        if not any(low <= n < high for low, high in ranges)
    ]
    for low, high in ranges:
        indices = np.linspace(low, high, _REFINEMENT * (high - low) + 1)
        finer = np.interp(indices, np.arange(grid.size), grid)
        brackets += _find_brackets(margins_at, finer, level + 1)
    return sorted(brackets)


def _near_zero_indices(margins: FloatArray, conditions_hold: BoolArray) -> Any:
    # Indices of local minima of |margin| between neighbours of the same sign. A margin two points
    # away exceeds the minimum by a factor, as for two lines or a parabola that touch zero. Minima
    # where the other conditions fail at all three points are omitted: there is no stability.
    size, stable, index = np.abs(margins), margins > 0.0, np.arange(margins.size)
    far_before, before, after, far_after = (
        np.clip(index + offset, 0, margins.size - 1) for offset in (-2, -1, 1, 2)
    )
    same_sign = (stable[before] == stable) & (stable == stable[after])
    may_be_stable = conditions_hold[before] | conditions_hold | conditions_hold[after]
    smallest = (size <= size[before]) & (size <= size[after])
    nearly_touches = _RISE_FACTOR * size < np.maximum(size[far_before], size[far_after])
    return np.flatnonzero(same_sign & may_be_stable & smallest & nearly_touches).tolist()


def _merge_ranges(ranges: list[tuple[int, int]]) -> list[tuple[int, int]]:
    # Ranges of indices, ascending, with overlapping ranges merged.
    merged: list[tuple[int, int]] = []
    for low, high in sorted(ranges):
        if merged and low < merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _locate_zero(function: Callable[[float], float], low: float, high: float) -> float:
    # If rounding gives both ends the same sign, the zero is the end of the smaller absolute value.
    from scipy.optimize import brentq

    at_low, at_high = function(low), function(high)
    if (at_low > 0.0) == (at_high > 0.0):
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-300, rtol=1e-15))

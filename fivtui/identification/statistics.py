"""What a fit says of its unknowns: intervals, correlations, and directions that remain unknown."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from fivtui.model import ComputationError

from .problem import COARSE_TOL, Problem, Solution

Floats = NDArray[np.float64]

CONFIDENCE: Final = 0.95
# Singular values of the Jacobian with unit columns below this count as zero.
_SINGULAR: Final = 1e-6
# Columns below this, relative to the largest for equal relative changes, have no effect.
_NO_EFFECT: Final = 1e-9
# Components of a direction above this, relative to the largest, belong to it.
_COMPONENT: Final = 0.02
# Relative difference of components that count as equal: the unknowns scale together.
_EQUAL: Final = 0.05
# Number of intervals that are checked by a profile, and steps of each search for an end.
_PROFILED: Final = 2
_PROFILE_STEPS: Final = 4
_PROFILE_TOL: Final = 0.02
# Relative standard deviations below this need no profile: residuals are linear over them.
_LEAST_PROFILED: Final = 1e-6
# Residuals below this, relative to the signal, are rounding errors.
_ROUNDING: Final = 1e-9


class Intervals(NamedTuple):
    """Standard deviations and 95 % intervals of coordinates, and their correlation matrix."""

    sd: Floats
    low: Floats
    high: Floats
    correlation: Floats


def find_unknown(problem: Problem, solution: Solution) -> dict[str, frozenset[int]]:
    """What the data do not determine: a phrase each, and the indices of the unknowns."""
    jacobian, keys = solution.jacobian, [unknown.key for unknown in problem.unknowns]
    sizes = np.linalg.norm(jacobian, axis=0)
    # Coordinates per relative change of the value.
    scales = np.array(
        [
            1.0 if unknown.is_logarithmic else max(abs(value), _NO_EFFECT)
            for unknown, value in zip(problem.unknowns, solution.z.tolist(), strict=True)
        ]
    )
    effects = sizes * scales
    directions: dict[str, frozenset[int]] = {}
    idle = np.flatnonzero(effects <= _NO_EFFECT * max(float(effects.max()), 1.0))
    for index in idle.tolist():
        directions[f"{keys[index]} has no effect on the data: do not fit it"] = frozenset({index})
    used = np.setdiff1d(np.arange(len(keys)), idle)
    if used.size == 0:
        return directions
    # The triangular factor has the singular values of the Jacobian, and few rows.
    triangle = np.linalg.qr(jacobian[:, used] / sizes[used], mode="r")
    _, singular_values, rows = np.linalg.svd(triangle, full_matrices=True)
    singular_values = np.pad(singular_values, (0, used.size - singular_values.size))
    null_space = rows[singular_values <= _SINGULAR * singular_values[0]] / effects[used]
    if not len(null_space):
        return directions
    null_space /= np.abs(null_space).max(axis=1, keepdims=True)
    reach = np.abs(null_space).max(axis=0)
    members = used[reach > _COMPONENT].tolist()
    names = ", ".join(keys[index] for index in members)
    count = len(null_space)
    components = null_space[0][reach > _COMPONENT]
    if count == 1 and np.ptp(components) < _EQUAL:
        text = f"{names} scale together: fix one"
    else:
        text = f"only combinations of {names} are known: fix {'one' if count == 1 else count}"
    directions[text] = frozenset(members)
    return directions


def compute_intervals(
    problem: Problem,
    solution: Solution,
    t_end: float,
    determined: Sequence[int],
    *,
    known_noise: bool,
) -> Intervals:
    """Intervals from the Jacobian; ends of the two widest ones from profiles of the residuals.

    NaN for all unknowns but those `determined`.
    """
    jacobian = solution.jacobian[:, determined]
    sizes = np.linalg.norm(jacobian, axis=0)
    inverse = np.linalg.pinv(jacobian / sizes) / sizes[:, None]
    covariance = np.full((solution.z.size, solution.z.size), np.nan)
    covariance[np.ix_(determined, determined)] = inverse @ inverse.T
    sd = np.sqrt(np.diag(covariance))
    freedom = solution.residuals.size - solution.z.size
    level = 0.5 + 0.5 * CONFIDENCE
    factor = float(stats.norm.ppf(level) if known_noise else stats.t.ppf(level, max(freedom, 1)))
    ends = solution.z + factor * np.array([-sd, sd])
    relative_sd = {
        index: float(sd[index] / (1.0 if unknown.is_logarithmic else max(abs(value), sd[index])))
        for index, (unknown, value) in enumerate(zip(problem.unknowns, solution.z, strict=True))
        if index in determined
    }
    for index in sorted(relative_sd, key=relative_sd.__getitem__)[-_PROFILED:]:
        if relative_sd[index] > _LEAST_PROFILED:
            slope = np.nan_to_num(covariance[:, index] / sd[index])
            for end, step in enumerate((-factor * slope, factor * slope)):
                ends[end, index] += _profile_shift(problem, (solution, t_end), index, step, factor)
    low, high = np.clip(ends, *problem.bounds())
    return Intervals(sd, low, high, covariance / np.outer(sd, sd))


def _profile_shift(
    problem: Problem, fitted: tuple[Solution, float], index: int, step: Floats, target: float
) -> float:
    # By how much the end of an interval moves. The end is where the norm of the residuals, at the
    # best values of all other unknowns, grows by `target`; `step` leads there from the solution.
    solution, t_end = fitted
    least, scale = float(solution.residuals @ solution.residuals), 1.0
    low, high = problem.bounds()
    for _ in range(_PROFILE_STEPS):
        start = np.clip(solution.z + scale * step, low, high)
        try:
            fixed = problem.solve(start, t_end, fixed=index, tol=COARSE_TOL)
        except ComputationError:
            break
        growth = math.sqrt(max(float(fixed.residuals @ fixed.residuals) - least, 0.0))
        if abs(growth / target - 1.0) < _PROFILE_TOL:
            break
        scale *= min(max(target / max(growth, _PROFILE_TOL), 0.5), 2.0)
    return (scale - 1.0) * float(step[index])


def residual_runs_test(problem: Problem, residuals: Floats, t_end: float) -> float:
    """`runs_test` of the residuals of a fit, without those of signals that are fitted exactly."""
    return runs_test(
        [
            part
            for quantity, parts in problem.signal_residuals(residuals, t_end).items()
            for record, part in zip(problem.records, parts, strict=True)
            if part.std() > _ROUNDING * record.signals[quantity].std()
        ]
    )


def runs_test(residuals: Sequence[Floats]) -> float:
    """Probability of so few or many runs of one sign if residuals are independent.

    The test of Wald and Wolfowitz, over the residuals of all signals.
    """
    expected = variance = runs = 0.0
    for part in residuals:
        signs = part > np.median(part)
        above = int(np.count_nonzero(signs))
        product, total = 2.0 * above * (signs.size - above), signs.size
        if product == 0.0:
            continue
        runs += 1 + int(np.count_nonzero(signs[1:] != signs[:-1]))
        expected += product / total + 1.0
        variance += product * (product - total) / (total * total * (total - 1.0))
    return (
        float(2.0 * stats.norm.sf(abs(runs - expected) / math.sqrt(variance)))
        if variance > 0.0
        else 1.0
    )

"""The solution of a fit: growing windows of the records, and several starts if the first is poor.

A growing or chaotic motion has no useful derivative over a long time. So the first part of the
records is fitted first, and the fitted part is doubled until it is the whole or the fit is lost.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from fivtui.model import ComputationError
from fivtui.orbits import slowest_period

from .problem import COARSE_TOL, Problem, Solution
from .statistics import residual_runs_test

Floats = NDArray[np.float64]

# The first window: periods of the slowest mode, and samples for each unknown.
_FIRST_PERIODS: Final = 1.0
_FIRST_SAMPLES: Final = 8
# Residuals above this fraction of the signals' standard deviation are a poor fit.
_POOR: Final = 0.1
# Probability of the runs test below which residuals are not noise.
_LEAST_RUNS_PROBABILITY: Final = 1e-3
# Number of further starts, and their range as a factor where the bounds are farther.
_STARTS: Final = 32
_START_FACTOR: Final = 4.0
# Repeated estimates of the noise: signals get the weights of their residuals.
_NOISE_ESTIMATES: Final = 2
_LEAST_SHARE: Final = 1e-3
_LEAST_SPREAD: Final = 1e-150


class Fit(NamedTuple):
    """A solution, and how it came about."""

    solution: Solution
    # Time up to which samples are fitted, s.
    t_end: float
    # Ratio of the residuals to the signals, both as root mean square deviations.
    misfit: float
    windows: int
    starts: int


def solve(problem: Problem, *, estimate_noise: bool) -> Fit:
    """Fit growing windows of the records; estimate the noise of signals where it is not given."""
    low, high = problem.bounds()
    z = np.clip([u.coordinate(u.value) for u in problem.unknowns], low, high)
    windows = _windows(problem)
    fitted = _solve_window(problem, z, windows[0])
    starts = 1
    if _is_poor(problem, fitted):
        for start in _starts(problem, z):
            starts += 1
            try:
                candidate = _solve_window(problem, start, windows[0])
            except ComputationError:
                continue
            if candidate.misfit < fitted.misfit:
                fitted = candidate
            if not _is_poor(problem, fitted):
                break
    for count, t_end in enumerate(windows[1:], 2):
        problem.work.report(count / (len(windows) + 2))
        longer = _solve_window(problem, fitted.solution.z, t_end)
        if _is_poor(problem, longer) and not _is_poor(problem, fitted):
            # The longer window is lost.
            break
        fitted = longer._replace(windows=count)
    for _ in range(_NOISE_ESTIMATES):
        if estimate_noise:
            _estimate_noise(problem, fitted)
        solution = problem.solve(fitted.solution.z, fitted.t_end)
        fitted = fitted._replace(solution=solution, misfit=_misfit(problem, solution, fitted.t_end))
    return fitted._replace(starts=starts)


def _windows(problem: Problem) -> list[float]:
    # Ends of the windows, s, the last one that of the records; infinity without records.
    if not problem.records:
        return [math.inf]
    t_end = max(float(record.t[-1]) for record in problem.records)
    first_samples = _FIRST_SAMPLES * len(problem.unknowns)
    ends = [float(record.t[:first_samples][-1]) for record in problem.records]
    t = max(_FIRST_PERIODS * slowest_period(problem.scene.parameters), *ends)
    windows = [t_end]
    while windows[0] > 2.0 * t:
        windows.insert(0, 0.5 * windows[0])
    return windows


def _solve_window(problem: Problem, z: Floats, t_end: float) -> Fit:
    solution = problem.solve(z, t_end, near=z, tol=COARSE_TOL)
    return Fit(solution, t_end, _misfit(problem, solution, t_end), 1, 1)


def _misfit(problem: Problem, solution: Solution, t_end: float) -> float:
    # Greatest ratio of residuals to signal; that of a target is poor at three standard deviations.
    ratios = [0.0]
    for quantity, parts in problem.signal_residuals(solution.residuals, t_end).items():
        signal = np.concatenate(
            [record.signals[quantity][record.t <= t_end] for record in problem.records]
        )
        ratios.append(float(np.concatenate(parts).std() / max(signal.std(), _LEAST_SPREAD)))
    if problem.targets:
        deviations = solution.residuals[-len(problem.targets) :]
        ratios.append(_POOR / 3.0 * float(np.sqrt(np.mean(deviations**2))))
    return max(ratios)


def _is_poor(problem: Problem, fitted: Fit) -> bool:
    # Whether residuals are large and not just noise, whose signs follow each other at random.
    if fitted.misfit <= _POOR:
        return False
    if not problem.records:
        return True
    residuals = fitted.solution.residuals
    return residual_runs_test(problem, residuals, fitted.t_end) < _LEAST_RUNS_PROBABILITY


def _estimate_noise(problem: Problem, fitted: Fit) -> None:
    # Set the noise to the standard deviations of the residuals, with the degrees of freedom left.
    solution = fitted.solution
    share = max(1.0 - solution.z.size / solution.residuals.size, _LEAST_SHARE)
    for quantity, parts in problem.signal_residuals(solution.residuals, fitted.t_end).items():
        mean_square = float(np.mean(np.concatenate(parts) ** 2))
        problem.noise[quantity] = max(math.sqrt(mean_square / share), _LEAST_SPREAD)


def _starts(problem: Problem, z: Floats) -> Floats:
    # Scattered starts within the bounds.
    low, high = problem.bounds()
    reach = math.log(_START_FACTOR) * problem.spreads()
    sobol = qmc.Sobol(z.size, rng=0)
    return qmc.scale(sobol.random(_STARTS), np.maximum(low, z - reach), np.minimum(high, z + reach))

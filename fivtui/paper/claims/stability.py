"""Tests of the claims of sections 2 to 4: damping, contact, equilibria and their stability.

A test returns whether the claim holds, and the numbers that `statements.toml` names. Figures are
identified by their number. `columns` maps the k_nl or F that distinguishes a line of a figure to
the values along this line.
"""

import math
from collections.abc import Callable, Mapping
from itertools import product
from typing import Final

import numpy as np

from fivtui.equilibrium import growth_rate, stability
from fivtui.model import (
    Mode,
    Parameters,
    System,
    contact_force,
    equilibrium,
    jacobian,
    static_start,
    tangent_stiffness,
)
from fivtui.paper import FloatArray, PaperResults, critical_mu, modes
from fivtui.scene import PRESETS
from fivtui.simulation import simulate
from fivtui.transient import Trajectory, finite_trajectory

from .claim import Finding, Test, Values
from .trends import build_test, columns, crossing, falls, falls_then_rises, rises, trend

_BASE: Final = Parameters()
# The friction coefficient of two claims, and the linear system at it.
_STRONG_MU: Final = 1.2
_LINEAR: Final = _BASE.with_values({"k_nl": 0.0, "mu": _STRONG_MU})
# Rounding errors of displacements (m) and Jacobians, and of critical friction coefficients.
_ROUNDING: Final = 1e-12
_MU_ROUNDING: Final = 1e-9
# Greatest error of the displacement, m, or of the contact force, N, at a located reattachment.
_REATTACHMENT_TOL: Final = 1e-9
# Key in `columns` of the line of the linear system: it has k_nl = 0, or F = 0 and so y_e = 0.
_LINEAR_LINE: Final = 0.0
# Frequencies closer than this have merged, rad/s.
_MERGED: Final = 1e-6
# Frequencies farther apart than this have not merged, rad/s.
_SEPARATE: Final = 1e-3


def _proportional_damping(_: PaperResults) -> Finding:
    lower, upper = modes(stability(_BASE.with_values({"mu": 0.0})))
    expected = -_BASE.c1 / (2.0 * _BASE.m)
    is_equal = all(math.isclose(mode.real, expected, rel_tol=1e-9) for mode in (lower, upper))
    return is_equal, (lower.real, upper.real, expected)


def _contact_means_negative_y(_: PaperResults) -> Finding:
    sets = [_BASE.with_values({"k_nl": k_nl}) for k_nl in (0.0, 20.0, 100.0, 500.0)]
    points = list(product(sets, np.linspace(-5.0, 5.0, 2001).tolist()))
    contradictions = sum((contact_force(p, y, Mode.CONTACT) > 0.0) != (y < 0.0) for p, y in points)
    return contradictions == 0, (len(points), contradictions)


def _states_at_reattachments(paper: PaperResults) -> Trajectory:
    # States of the base scene at each reattachment; the last interval may end with the run.
    scene = PRESETS["base"]
    run = paper.run(scene)
    ends = [end for _, end in run.separated_intervals if end < run.t_end]
    return finite_trajectory(
        simulate(scene.parameters, t_end=scene.t_end, tol=scene.tol, samples=ends)
    )


def _reattachment_without_force(paper: PaperResults) -> Finding:
    force = np.abs(_states_at_reattachments(paper).P)
    return force.max() <= _REATTACHMENT_TOL, (force.size, force.max())


def _reattachment_at_the_static_position(paper: PaperResults) -> Finding:
    y = _states_at_reattachments(paper).y
    # The static position under the preload is below y = 0, where the contact spring is undeformed.
    _, _, static_y, _ = static_start(System(_BASE))
    return np.abs(y - static_y).max() <= _REATTACHMENT_TOL, (np.abs(y).max(), static_y)


def _one_real_equilibrium(_: PaperResults) -> Finding:
    root_counts, differences = set(), []
    for k_nl, F in product((1.0, 50.0, 100.0, 500.0), (5.0, 20.0, 50.0, 100.0)):
        p = _BASE.with_values({"k_nl": k_nl, "F": F})
        # Eq. 6 with h = k3/2 and P = -k2 y - k_nl y³: k_x x = h y + μ P and h (x - y) + P = F. The
        # first equation eliminates x from the second, which becomes a cubic in y.
        h = 0.5 * p.k3
        k_x = p.k1 + h
        linear = p.k2 + h - h * (h - p.mu * p.k2) / k_x
        cubic = p.k_nl + h * p.mu * p.k_nl / k_x
        roots = np.roots((cubic, 0.0, linear, p.F))
        real_roots = roots.real[np.isclose(roots.imag, 0.0, atol=1e-9)]
        root_counts.add(real_roots.size)
        differences.append(abs(float(real_roots[0]) - equilibrium(System(p)).y))
    holds = root_counts == {1} and max(differences) < 1e-9
    return holds, (max(root_counts), max(differences))


def _preload_brings_stiffness_into_the_jacobian(_: PaperResults) -> Finding:
    def jacobian_change(F: float) -> float:
        # Greatest change of an element of the Jacobian by k_nl.
        sets = [_BASE.with_values({"F": F, "k_nl": k_nl}) for k_nl in (0.0, _BASE.k_nl)]
        linear, nonlinear = (
            np.array(jacobian(p, equilibrium(System(p)).y, Mode.CONTACT)) for p in sets
        )
        return float(np.abs(nonlinear - linear).max())

    unloaded, loaded = jacobian_change(0.0), jacobian_change(_BASE.F)
    stiffness = tangent_stiffness(_BASE, equilibrium(System(_BASE)).y)
    return unloaded <= _ROUNDING < loaded, (unloaded, loaded, stiffness)


def _count_exceptions(paper: PaperResults, *keys: str) -> tuple[int, int]:
    # Numbers of points, and of exceptions to the rule that motion grows exactly above μ_c.
    points = exceptions = 0
    for line in (line for key in keys for _, line in paper.table(key).lines()):
        growth = np.maximum(line["sigma_1"], line["sigma_2"])
        points += growth.size
        exceptions += int(np.sum((growth > 0.0) != (line["mu"] > line["mu_c"])))
    return points, exceptions


def _frequencies_merge(_: PaperResults) -> Finding:
    def frequency_gap(p: Parameters, share: float) -> float:
        # Difference of both frequencies at a share of the critical friction, rad/s.
        lower, upper = modes(stability(p.with_values({"mu": share * critical_mu(p)})))
        return abs(upper.imag - lower.imag)

    grid = product((20.0, 100.0), (0.0, 50.0, 100.0, 500.0))
    sets = [_BASE.with_values({"F": F, "k_nl": k_nl}) for F, k_nl in grid]
    least_below = min(frequency_gap(p, 0.99) for p in sets)
    greatest_at = max(frequency_gap(p, 1.0) for p in sets)
    return least_below > 0.0 and greatest_at <= _MERGED, (least_below, greatest_at)


def _critical_values(paper: PaperResults, key: str) -> Values:
    # μ_c of the lines of Figs. 3 to 5, the linear one first.
    return [line[0] for line in columns(paper, key, "mu_c").values()]


def _mu_c_test(key: str, holds: Callable[..., bool]) -> Test:
    # A test by the μ_c of the lines of a figure.
    return build_test(lambda paper: _critical_values(paper, key), holds)


def _no_coalescence(paper: PaperResults) -> Finding:
    gaps = [line["omega_2"] - line["omega_1"] for _, line in paper.table("5").lines()]
    # The frequencies come closer than at μ = 0, the first point, but never merge.
    approach = all(gap.min() < gap[0] for gap in gaps)
    never_merge = all(gap.min() > _SEPARATE for gap in gaps)
    return approach and never_merge, [gap.min() for gap in gaps]


def _one_real_part_passes_zero(paper: PaperResults) -> Finding:
    lines = [line for _, line in paper.table("5").lines()]
    one_decays = all(np.all(np.minimum(line["sigma_1"], line["sigma_2"]) < 0.0) for line in lines)
    _, exceptions = _count_exceptions(paper, "5")
    return one_decays and exceptions == 0, _critical_values(paper, "5")


def _growth_test(name: str, *values: float) -> Test:
    # A test that the second of three values of a parameter is unstable, the others stable.
    return build_test(
        lambda _: [
            growth_rate(System(_BASE.with_values({name: value}), separation=False))
            for value in values
        ],
        lambda before, between, after: before < 0.0 < between and after < 0.0,
    )


def _mu_c_lines(paper: PaperResults, *keys: str) -> tuple[float, list[FloatArray]]:
    # μ_c of the linear system, and along the nonlinear lines of Figs. 6 to 9.
    panels = [columns(paper, key, "mu_c") for key in keys]
    lines = [line for panel in panels for value, line in panel.items() if value > 0.0]
    # All values along the linear line are the same μ_c.
    return float(panels[0][_LINEAR_LINE][0]), lines


def _linear_mu_c_and_its_change(paper: PaperResults) -> Values:
    linear_line = columns(paper, "6", "mu_c")[_LINEAR_LINE]
    return float(linear_line[0]), np.ptp(linear_line)


def _first_below_linear(paper: PaperResults, key: str) -> Finding:
    # Whether all lines fall from the linear μ_c to a minimum.
    linear, lines = _mu_c_lines(paper, key)
    to_minimum = [line[: np.argmin(line) + 1] for line in lines]
    # The first point is the linear system but for rounding: the second must be below it, too.
    holds = all(line.size > 1 and falls(line) and line[1] < linear for line in to_minimum)
    return holds, (linear, *(line[-1] for line in to_minimum))


def _preload_stabilises_later(paper: PaperResults) -> Finding:
    _, lines = _mu_c_lines(paper, "6")
    # All lines have the same preloads.
    preloads = columns(paper, "6", "F")[_LINEAR_LINE]
    minima = [preloads[np.argmin(line)] for line in lines]
    return all(map(falls_then_rises, lines)) and falls(minima), minima


def _exceeds_linear(paper: PaperResults, key: str, along: str) -> Finding:
    # Whether the last line crosses the linear μ_c once, upwards. The last number is where.
    linear, lines = _mu_c_lines(paper, key)
    begin = crossing(columns(paper, key, along)[_LINEAR_LINE], lines[-1] - linear)
    return begin is not None, (linear, *(line[-1] for line in lines), begin)


def _same_trend_with_other_damping(_: PaperResults) -> Finding:
    base = _BASE.with_values({"c1": 0.8})
    preloads = np.linspace(0.0, 100.0, 101)
    linear = critical_mu(base.with_values({"k_nl": 0.0}))
    holds, values = True, [linear]
    stiffnesses = (50.0, 200.0, 500.0)
    for k_nl in stiffnesses:
        sets = (base.with_values({"k_nl": k_nl, "F": F}) for F in preloads.tolist())
        line = np.array([critical_mu(p) for p in sets])
        # The stiffest line alone ends above the linear μ_c.
        ends_above, is_stiffest = bool(line[-1] > linear), k_nl == max(stiffnesses)
        holds &= falls_then_rises(line) and ends_above == is_stiffest
        values += [preloads[np.argmin(line)], line[-1]]
    return holds, values


def _small_preload_stays_below_linear(paper: PaperResults) -> Finding:
    linear, (line, *_) = _mu_c_lines(paper, "7")
    return np.all(line[1:] < linear), (linear, line[-1])


def _stabilised_at_1_2(_: PaperResults) -> Finding:
    from scipy.optimize import brentq

    p = _BASE.with_values({"F": 100.0, "k_nl": 300.0, "mu": _STRONG_MU})
    growth = growth_rate(System(p))

    def excess(k_nl: float) -> float:
        return critical_mu(p.with_values({"k_nl": k_nl})) - _STRONG_MU

    least_stiffness = brentq(excess, 100.0, 500.0, xtol=1e-9)
    return growth < 0.0, (critical_mu(p), growth, least_stiffness)


def _soft_horizontal_more_stable(paper: PaperResults) -> Finding:
    linear, lines = _mu_c_lines(paper, "8", "9")
    # The first point of every line is the linear system.
    least = min(line[1:].min() for line in lines)
    return least > linear, (linear, least - linear, max(line.max() for line in lines))


def _soft_horizontal_monotonic(paper: PaperResults) -> Finding:
    _, lines = _mu_c_lines(paper, "8", "9")
    return trend(rises, lines, -1)


TESTS: Final[Mapping[str, Test]] = {
    "proportional-damping": _proportional_damping,
    "contact-means-negative-y": _contact_means_negative_y,
    "reattachment-without-force": _reattachment_without_force,
    "reattachment-at-the-static-position": _reattachment_at_the_static_position,
    "one-real-equilibrium": _one_real_equilibrium,
    "equilibrium-sinks-with-preload": lambda paper: trend(
        falls, columns(paper, "2a", "y_e").values(), -1
    ),
    # y_e is negative with preload; the first line has none.
    "stiffness-resists-displacement": lambda paper: trend(
        rises, list(columns(paper, "2b", "y_e").values())[1:], 0, -1
    ),
    "no-preload-no-displacement": build_test(
        lambda paper: [np.ptp(columns(paper, "2b", "y_e")[_LINEAR_LINE])],
        lambda change: change <= _ROUNDING,
    ),
    "preload-brings-stiffness-into-the-jacobian": _preload_brings_stiffness_into_the_jacobian,
    "one-critical-friction": build_test(
        lambda paper: _count_exceptions(paper, "3", "4"),
        lambda _points, exceptions: exceptions == 0,
    ),
    "frequencies-merge": _frequencies_merge,
    "critical-friction-falls-at-small-preload": _mu_c_test("3", lambda _, *mu: falls(mu)),
    "below-linear-at-small-preload": _mu_c_test("3", lambda linear, *mu: max(mu) < linear),
    "critical-friction-rises-at-large-preload": _mu_c_test("4", lambda _, *mu: rises(mu)),
    "strong-nonlinearity-above-linear": _mu_c_test("4", lambda linear, *mu: mu[-1] > linear),
    "weak-nonlinearities-below-linear": _mu_c_test("4", lambda linear, *mu: max(mu[:-1]) < linear),
    "no-coalescence": _no_coalescence,
    "one-real-part-passes-zero": _one_real_part_passes_zero,
    "preload-destabilises-then-stabilises": _growth_test("F", 0.0, 60.0, 120.0),
    "stiffness-destabilises-then-stabilises": _growth_test("k_nl", 0.0, 100.0, 500.0),
    "preload-leaves-the-linear-system": build_test(
        _linear_mu_c_and_its_change, lambda _, change: change <= _MU_ROUNDING
    ),
    "preload-destabilises-at-first": lambda paper: _first_below_linear(paper, "6"),
    "preload-stabilises-later": _preload_stabilises_later,
    "preload-stabilises-beyond-linear": lambda paper: _exceeds_linear(paper, "6", "F"),
    "same-trend-with-other-damping": _same_trend_with_other_damping,
    "stiffness-needs-preload": build_test(
        lambda paper: [np.ptp(columns(paper, "7", "mu_c")[_LINEAR_LINE])],
        lambda change: change <= _MU_ROUNDING,
    ),
    "stiffness-destabilises-at-first": lambda paper: _first_below_linear(paper, "7"),
    "stiffness-stabilises-at-large-preload": lambda paper: _exceeds_linear(paper, "7", "k_nl"),
    "small-preload-stays-below-linear": _small_preload_stays_below_linear,
    "linear-unstable-at-1-2": build_test(
        lambda _: (critical_mu(_LINEAR), growth_rate(System(_LINEAR))),
        lambda critical, growth: critical < _STRONG_MU and growth > 0.0,
    ),
    "stabilised-at-1-2": _stabilised_at_1_2,
    "soft-horizontal-more-stable": _soft_horizontal_more_stable,
    "soft-horizontal-monotonic": _soft_horizontal_monotonic,
}

"""Tests of the claims of sections 1, 5 and 6: vibration with separation considered and ignored.

A test returns whether the claim holds, and computed numbers, whose names are in the claim's row of
`statements.toml`. Figures 13 to 16 have two lines: separation considered (Case 1), and ignored.
"""

import dataclasses
from collections.abc import Callable, Mapping
from itertools import product
from typing import Any, Final

import numpy as np

from fivtui.equilibrium import growth_rate
from fivtui.model import Mode, Parameters, System, equilibrium
from fivtui.orbits import EventKind, branch
from fivtui.paper import Amplitude, FloatArray, PaperResults, critical_mu
from fivtui.scene import PRESETS, Scene
from fivtui.transient import finite_trajectory

from .claim import Finding, Test, Values
from .trends import build_test, columns, crossing, falls, rises, trend

_BASE: Final = Parameters()
# At rest under the preload before the belt moves: the equilibrium at μ = 0.
_STATIC: Final = equilibrium(System(_BASE), mu=0.0)
_CONSIDERED: Final = PRESETS["base"]
_IGNORED: Final = PRESETS["separation-ignored"]
_COEXISTENCE: Final = PRESETS["coexistence"]
# Values of the column `separation`, which distinguishes the lines of the figures.
_LINE_CONSIDERED: Final = 1.0
_LINE_IGNORED: Final = 0.0
_FIGURES: Final = ("13", "14", "15", "16")
# Columns that measure the amplitude: greatest |y|, and half peak-to-peak of y in the second half of
# the run.
_MEASURES: Final = ("y_peak", "y_half_range")
# Indices of the ends of a line.
_ENDS: Final = (0, -1)
# Greatest ratio of amplitudes along a figure that counts as "barely affected", and least ratio that
# counts as affected.
_BARELY_RATIO: Final = 1.2
_CLEAR_RATIO: Final = 5.0


def _scene_with(scene: Scene, values: Mapping[str, float], **settings: Any) -> Scene:
    return dataclasses.replace(scene, **settings).with_values(values)


# The same growing motion over two horizons.
_UNBOUNDED: Final = tuple(
    _scene_with(PRESETS["linear"], {"mu": 1.2}, name="linear, unstable", t_end=t_end)
    for t_end in (30.0, 60.0)
)
# Scenes that differ in the preload alone.
_PRELOAD_ALONE: Final = tuple(
    _scene_with(_CONSIDERED, {"F": F, "k_nl": 100.0, "mu": 0.7}, name="preload alone", tol=1e-9)
    for F in (40.0, 60.0)
)


def _stable_starts() -> tuple[Scene, ...]:
    # Static starts at parameters similar to the paper's; the horizon lets a motion decay.
    base = dataclasses.replace(_CONSIDERED, name="static start", t_end=200.0, tol=1e-9)
    grid = product(range(10, 151, 20), (20.0, 50.0, 100.0, 200.0, 500.0), (0.3, 0.5, 0.7, 1.0))
    scenes = (base.with_values({"F": F, "k_nl": k_nl, "mu": mu}) for F, k_nl, mu in grid)
    return tuple(scene for scene in scenes if growth_rate(System(scene.parameters)) < 0.0)


def _pushed_up(offset: float) -> Scene:
    # A start at the equilibrium, displaced upwards by `offset`, m.
    point = equilibrium(System(_COEXISTENCE.parameters))
    start = (point.x, 0.0, point.y + offset, 0.0)
    return dataclasses.replace(_COEXISTENCE, name=f"offset {offset:g} m", start=start)


_STABLE: Final = _stable_starts()
# Three starts at the same parameters, at which a stable equilibrium and a limit cycle coexist:
# static, displaced from the equilibrium by 0.3 m, and by 0.1 m.
_COEXISTENCE_STARTS: Final = (_COEXISTENCE, _pushed_up(0.3), PRESETS["coexistence-decay"])


def _linear_contact_unbounded(paper: PaperResults) -> Finding:
    early, late = (amplitude.y_half_range for amplitude in paper.amplitudes(_UNBOUNDED))
    growth = growth_rate(System(_UNBOUNDED[0].parameters))
    return late > 1e3 * early and growth > 0.0, (early, late, growth)


def _stable_seldom_separates(paper: PaperResults) -> Finding:
    separated = sum(amplitude.separations > 0 for amplitude in paper.amplitudes(_STABLE))
    return separated < 0.5 * len(_STABLE), (len(_STABLE), separated)


def _has_returned(amplitude: Amplitude) -> bool:
    # Decay to equilibrium: in the second half of the run, half peak-to-peak is below a tenth of the
    # peak.
    return amplitude.y_half_range < 0.1 * amplitude.y_peak


def _stable_returns_to_equilibrium(paper: PaperResults) -> Finding:
    separated = [amplitude for amplitude in paper.amplitudes(_STABLE) if amplitude.separations]
    returned = sum(map(_has_returned, separated))
    static, *displaced = paper.amplitudes(_COEXISTENCE_STARTS)
    growth = growth_rate(System(_COEXISTENCE.parameters))
    half_ranges = [amplitude.y_half_range for amplitude in (static, *displaced)]
    holds = returned == len(separated) and _has_returned(static)
    return holds, (len(separated), returned, growth, *half_ranges)


def _critical_friction_of_the_example(_: PaperResults) -> Finding:
    critical = critical_mu(_BASE)
    events = branch(_BASE, "mu", low=0.0, high=critical).events
    fold = next(event for event in events if event.kind is EventKind.FOLD)
    lighter = critical_mu(_BASE.with_values({"F": 50.0}))
    return abs(critical - 0.28) < 0.005, (critical, fold.value, lighter)


def _ignored_contact_force_becomes_negative(paper: PaperResults) -> Finding:
    trajectory = finite_trajectory(paper.run(_IGNORED))
    P, is_negative = trajectory.P, trajectory.P < 0.0
    first_negative = int(np.argmax(is_negative))
    greatest_before = P[:first_negative].max(initial=0.0)
    percentage = 100.0 * float(is_negative.mean())
    values = (P[0], greatest_before, trajectory.t[first_negative], P.min(), percentage)
    return is_negative.any() and first_negative > 0, values


def _contact_force_falls_to_zero_repeatedly(paper: PaperResults) -> Finding:
    run = paper.run(_CONSIDERED)
    force, count = run.contact_force, run.events.separations
    # Adding 0 turns -0 into 0.
    return force.min >= 0.0 and count > 10, (force.min + 0.0, force.max, count)


def _no_force_off_the_belt(paper: PaperResults) -> Finding:
    trajectory = finite_trajectory(paper.run(_CONSIDERED))
    is_off = trajectory.mode == Mode.SEPARATED
    greatest = np.abs(trajectory.P[is_off]).max()
    holds = greatest == 0.0 and np.all(trajectory.y[is_off] >= 0.0)
    return holds, (int(is_off.sum()), greatest)


def _stretched_spring_holds_back(paper: PaperResults) -> Finding:
    trajectory = finite_trajectory(paper.run(_IGNORED))
    P, y = trajectory.P, trajectory.y
    highest = paper.run(_CONSIDERED).peak.y_max
    return np.all(P[y > 0.0] < 0.0), (int((y > 0.0).sum()), P.min(), y.max(), highest)


def _separation_changes_both_motions(paper: PaperResults) -> Finding:
    peak, ignored = paper.run(_CONSIDERED).peak, paper.run(_IGNORED).peak
    holds = min(peak.x_abs / ignored.x_abs, peak.y_abs / ignored.y_abs) > 1.1
    return holds, (peak.x_abs, ignored.x_abs, peak.y_abs, ignored.y_abs)


def _asymmetry(paper: PaperResults, *names: str) -> Finding:
    # Whether columns of the trajectory deviate unequally upwards and downwards from their static
    # values, in the second half of the run, after the initial transient.
    run = paper.run(_CONSIDERED)
    trajectory = finite_trajectory(run)
    is_late = trajectory.t >= 0.5 * run.t_end
    excursions = []
    for name in names:
        deviations = getattr(trajectory, name)[is_late] - getattr(_STATIC, name)
        excursions.append((deviations.max(), -deviations.min()))
    is_unequal = all(max(pair) > 1.5 * min(pair) for pair in excursions)
    return is_unequal, [excursion for pair in excursions for excursion in pair]


def _separations_are_short(paper: PaperResults) -> Finding:
    run = paper.run(_CONSIDERED)
    durations = np.array([end - start for start, end in run.separated_intervals])
    share = run.events.separated_time / run.t_end
    mean_contact = (run.t_end - durations.sum()) / durations.size
    return share < 0.1, (100.0 * share, durations.max(), durations.mean(), mean_contact)


def _crossings(paper: PaperResults, key: str) -> list[float | None]:
    # The preload or stiffness, whichever varies along the figure, above which the amplitude is
    # greater with separation considered than ignored, for both measures; None without one crossing.
    ignored, considered = (line for _, line in paper.table(key).lines())
    varied_values = considered[considered.along]
    return [crossing(varied_values, considered[name] - ignored[name]) for name in _MEASURES]


def _check_barely_affected(paper: PaperResults, key: str) -> Finding:
    # Whether amplitudes barely change along a figure with separation ignored, but change with it
    # considered. The numbers are the ratios of the greatest to the least amplitude: of the peak,
    # ignored and considered, then of half peak-to-peak.
    holds, ratios = True, []
    for name in _MEASURES:
        lines = columns(paper, key, name)
        ignored, considered = (
            float(lines[case].max() / lines[case].min())
            for case in (_LINE_IGNORED, _LINE_CONSIDERED)
        )
        holds &= ignored < _BARELY_RATIO and considered > _CLEAR_RATIO
        ratios += [ignored, considered]
    return holds, ratios


def _check_growth(paper: PaperResults, key: str) -> Finding:
    # Whether amplitudes with separation considered rise along a figure.
    lines = [columns(paper, key, name)[_LINE_CONSIDERED] for name in _MEASURES]
    return trend(rises, lines, *_ENDS)


def _check_crossings(paper: PaperResults, key: str) -> Finding:
    # Whether amplitudes with separation considered exceed those with it ignored from some point on.
    crossings = _crossings(paper, key)
    return None not in crossings, crossings


def _same_trends_with_stronger_nonlinearity(paper: PaperResults) -> Finding:
    barely_affected, ratios = _check_barely_affected(paper, "14")
    peak_ratio_ignored, _, half_range_ratio_ignored, _ = ratios
    grows, ends = _check_growth(paper, "14")
    cross, crossings = _check_crossings(paper, "14")
    ignored_ratios = (peak_ratio_ignored, half_range_ratio_ignored)
    return barely_affected and grows and cross, (*ignored_ratios, *ends, *crossings)


def _below(low: Values, high: Values, share: float) -> bool:
    # Whether no value is None, and each `low` is less than a share of its `high`.
    pairs = zip(low, high, strict=True)
    return all(a is not None and b is not None and a < share * b for a, b in pairs)


def _stronger_nonlinearity_crosses_sooner(paper: PaperResults) -> Finding:
    weak, strong = _crossings(paper, "13"), _crossings(paper, "14")
    return _below(strong, weak, 0.5), (*weak, *strong)


def _half_ranges(paper: PaperResults, *keys: str) -> list[tuple[FloatArray, FloatArray]]:
    # Lines of figures: separation ignored, and considered.
    panels = [columns(paper, key, "y_half_range") for key in keys]
    return [(panel[_LINE_IGNORED], panel[_LINE_CONSIDERED]) for panel in panels]


def _along_stiffness(
    paper: PaperResults, case: float, rule: Callable[[FloatArray], bool]
) -> Finding:
    # Whether both measures follow a rule in one case, and the ends of the lines of half ranges.
    (peaks_follow, _), (half_ranges_follow, half_range_ends) = (
        trend(rule, [columns(paper, key, name)[case] for key in ("15", "16")], *_ENDS)
        for name in _MEASURES
    )
    return peaks_follow and half_ranges_follow, half_range_ends


def _greater_even_at_small_stiffness(paper: PaperResults) -> Finding:
    # The preload is 40 N in figure 15, 60 N in figure 16. Small stiffness is less than half the
    # crossing at 40 N, and in the first tenth of the range.
    crossings_40, crossings_60 = _crossings(paper, "15"), _crossings(paper, "16")
    greatest_stiffness = float(paper.table("16")["k_nl"].max())
    peaks = [line[0] for line in columns(paper, "16", "y_peak").values()]
    holds = _below(crossings_60, crossings_40, 0.5) and _below(
        crossings_60, [greatest_stiffness] * len(crossings_60), 0.1
    )
    return holds, (*crossings_60, *peaks)


def _amplitude_depends_on_preload(paper: PaperResults) -> Finding:
    lightly_loaded, heavily_loaded = paper.amplitudes(_PRELOAD_ALONE)
    peaks = (lightly_loaded.y_peak, heavily_loaded.y_peak)
    half_ranges = (lightly_loaded.y_half_range, heavily_loaded.y_half_range)
    holds = all(larger > 1.1 * smaller for smaller, larger in (peaks, half_ranges))
    return holds, (*peaks, *half_ranges)


def _opposite_trends(paper: PaperResults) -> Finding:
    # Changes of the half range along both figures, ignored and considered.
    changes = [
        (ignored[-1] - ignored[0], considered[-1] - considered[0])
        for ignored, considered in _half_ranges(paper, "15", "16")
    ]
    holds = all(ignored < 0.0 < considered for ignored, considered in changes)
    return holds, [change for pair in changes for change in pair]


TESTS: Final[Mapping[str, Test]] = {
    "linear-contact-unbounded": _linear_contact_unbounded,
    "stable-seldom-separates": _stable_seldom_separates,
    "stable-returns-to-equilibrium": _stable_returns_to_equilibrium,
    "critical-friction-of-the-example": _critical_friction_of_the_example,
    "ignored-contact-force-becomes-negative": _ignored_contact_force_becomes_negative,
    "contact-force-falls-to-zero-repeatedly": _contact_force_falls_to_zero_repeatedly,
    "no-force-off-the-belt": _no_force_off_the_belt,
    "stretched-spring-holds-back": _stretched_spring_holds_back,
    "separation-changes-both-motions": _separation_changes_both_motions,
    "vibration-asymmetric": lambda paper: _asymmetry(paper, "x", "y"),
    "contact-force-asymmetric": lambda paper: _asymmetry(paper, "P"),
    "separation-under-preload": build_test(
        lambda paper: (
            paper.run(_CONSIDERED).events.separations,
            next((start for start, _ in paper.run(_CONSIDERED).separated_intervals), None),
        ),
        lambda count, _: count > 0,
    ),
    "reattachment-follows-separation": build_test(
        lambda paper: (
            paper.run(_CONSIDERED).events.separations,
            paper.run(_CONSIDERED).events.reattachments,
        ),
        lambda separations, reattachments: 0 <= separations - reattachments <= 1,
    ),
    "separation-under-large-preload": build_test(
        lambda paper: [
            columns(paper, key, "separations")[_LINE_CONSIDERED][-1] for key in ("13", "14")
        ],
        lambda *counts: min(counts) > 0.0,
    ),
    "separations-are-short": _separations_are_short,
    "figures-show-unstable-motion": build_test(
        lambda paper: [paper.table(key)["growth_rate"].min() for key in _FIGURES],
        lambda *rates: min(rates) > 0.0,
    ),
    "ignored-barely-depends-on-preload": lambda paper: _check_barely_affected(paper, "13"),
    "considered-grows-with-preload": lambda paper: _check_growth(paper, "13"),
    "cases-cross-along-preload": lambda paper: _check_crossings(paper, "13"),
    "same-trends-with-stronger-nonlinearity": _same_trends_with_stronger_nonlinearity,
    "stronger-nonlinearity-crosses-sooner": _stronger_nonlinearity_crosses_sooner,
    "ignoring-separation-underestimates": build_test(
        lambda paper: [
            (considered / ignored).max() for ignored, considered in _half_ranges(paper, *_FIGURES)
        ],
        lambda *ratios: min(ratios) > 1.0,
    ),
    "ignored-falls-with-stiffness": lambda paper: _along_stiffness(paper, _LINE_IGNORED, falls),
    "considered-grows-with-stiffness": lambda paper: _along_stiffness(
        paper, _LINE_CONSIDERED, rises
    ),
    "cases-cross-along-stiffness": lambda paper: _check_crossings(paper, "15"),
    "greater-even-at-small-stiffness": _greater_even_at_small_stiffness,
    "amplitude-depends-on-preload": _amplitude_depends_on_preload,
    "opposite-trends": _opposite_trends,
}
SCENES: Final[Mapping[str, tuple[Scene, ...]]] = {
    "linear-contact-unbounded": _UNBOUNDED,
    "stable-seldom-separates": _STABLE,
    "stable-returns-to-equilibrium": (*_STABLE, *_COEXISTENCE_STARTS),
    "amplitude-depends-on-preload": _PRELOAD_ALONE,
}

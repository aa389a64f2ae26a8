"""Tests of the claims of sections 1, 5 and 6: vibration with separation considered and ignored."""

import dataclasses
from collections.abc import Callable, Mapping
from itertools import product
from typing import Any, Final

import numpy as np

from fivtui.equilibrium import growth_rate
from fivtui.model import Mode, Parameters, System, equilibrium, static_start
from fivtui.orbits import EventKind, branch
from fivtui.paper import Amplitude, FloatArray, PaperResults, critical_mu
from fivtui.scene import PRESETS, Scene
from fivtui.transient import checked_trajectory

from .claim import Finding, Test, Values
from .trends import columns, compare, crossing, falls, rises, trend

_BASE: Final = Parameters()
_CONSIDERED: Final = PRESETS["base"]
_IGNORED: Final = PRESETS["separation-ignored"]
_COEXISTENCE: Final = PRESETS["coexistence"]
_FIGURES: Final = ("13", "14", "15", "16")
_MEASURES: Final = ("y_peak", "y_half_range")
# Greatest ratio of amplitudes along a figure that counts as "barely affected".
_BARELY_RATIO: Final = 1.2


def _scene_with(scene: Scene, values: Mapping[str, float], **settings: Any) -> Scene:
    return dataclasses.replace(scene, **settings).with_values(values)


_UNBOUNDED: Final = tuple(
    _scene_with(PRESETS["linear"], {"mu": 1.2}, name="linear, unstable", t_end=t_end)
    for t_end in (30.0, 60.0)
)
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
    point = equilibrium(System(_COEXISTENCE.parameters))
    start = (point.x, 0.0, point.y + offset, 0.0)
    return dataclasses.replace(_COEXISTENCE, name=f"offset {offset:g} m", start=start)


_STABLE: Final = _stable_starts()
_ATTRACTORS: Final = (_COEXISTENCE, _pushed_up(0.3), PRESETS["coexistence-decay"])


def _linear_contact_unbounded(paper: PaperResults) -> Finding:
    early, late = (amplitude.y_half_range for amplitude in paper.amplitudes(_UNBOUNDED))
    growth = growth_rate(System(_UNBOUNDED[0].parameters))
    return late > 1e3 * early and growth > 0.0, (early, late, growth)


def _stable_seldom_separates(paper: PaperResults) -> Finding:
    separated = sum(amplitude.separations > 0 for amplitude in paper.amplitudes(_STABLE))
    return separated < 0.5 * len(_STABLE), (len(_STABLE), separated)


def _has_returned(amplitude: Amplitude) -> bool:
    # Decay to equilibrium: the second half of the run stays below a tenth of the peak.
    return amplitude.y_half_range < 0.1 * amplitude.y_peak


def _stable_returns_to_equilibrium(paper: PaperResults) -> Finding:
    separated = [amplitude for amplitude in paper.amplitudes(_STABLE) if amplitude.separations]
    returned = sum(map(_has_returned, separated))
    attractors = paper.amplitudes(_ATTRACTORS)
    counts = (len(separated), returned, growth_rate(System(_COEXISTENCE.parameters)))
    holds = returned == len(separated) and _has_returned(attractors[0])
    return holds, (*counts, *(amplitude.y_half_range for amplitude in attractors))


def _critical_friction_of_the_example(_: PaperResults) -> Finding:
    critical = critical_mu(_BASE)
    events = branch(_BASE, "mu", low=0.0, high=critical).events
    fold = next(event for event in events if event.kind is EventKind.FOLD)
    lighter = critical_mu(_BASE.with_values({"F": 50.0}))
    return abs(critical - 0.28) < 0.005, (critical, fold.value, lighter)


def _ignored_contact_force_becomes_negative(paper: PaperResults) -> Finding:
    trajectory = checked_trajectory(paper.run(_IGNORED))
    P, negative = trajectory.P, trajectory.P < 0.0
    first_negative = int(np.argmax(negative))
    greatest = P[:first_negative].max(initial=0.0)
    values = (P[0], greatest, trajectory.t[first_negative], P.min(), 100.0 * float(negative.mean()))
    return negative.any() and first_negative > 0, values


def _contact_force_falls_to_zero_repeatedly(paper: PaperResults) -> Finding:
    run = paper.run(_CONSIDERED)
    force, count = run.contact_force, run.events.separations
    return force.min >= 0.0 and count > 10, (force.min + 0.0, force.max, count)


def _no_force_off_the_belt(paper: PaperResults) -> Finding:
    trajectory = checked_trajectory(paper.run(_CONSIDERED))
    off = trajectory.mode == Mode.SEPARATED
    greatest = np.abs(trajectory.P[off]).max()
    return greatest == 0.0 and np.all(trajectory.y[off] >= 0.0), (int(off.sum()), greatest)


def _stretched_spring_holds_back(paper: PaperResults) -> Finding:
    trajectory = checked_trajectory(paper.run(_IGNORED))
    P, y = trajectory.P, trajectory.y
    highest = paper.run(_CONSIDERED).peak.y_max
    return np.all(P[y > 0.0] < 0.0), (int((y > 0.0).sum()), P.min(), y.max(), highest)


def _separation_changes_both_motions(paper: PaperResults) -> Finding:
    peak, ignored = paper.run(_CONSIDERED).peak, paper.run(_IGNORED).peak
    holds = min(peak.x_abs / ignored.x_abs, peak.y_abs / ignored.y_abs) > 1.1
    return holds, (peak.x_abs, ignored.x_abs, peak.y_abs, ignored.y_abs)


def _asymmetry(paper: PaperResults, **static: float) -> Finding:
    # Excursions in the second half of the run, after the initial transient.
    run = paper.run(_CONSIDERED)
    trajectory = checked_trajectory(run)
    late = trajectory.t >= 0.5 * run.t_end
    excursions = [getattr(trajectory, name)[late] - level for name, level in static.items()]
    sides = [(values.max(), -values.min()) for values in excursions]
    unequal = all(max(pair) > 1.5 * min(pair) for pair in sides)
    return unequal, [side for pair in sides for side in pair]


def _separations_are_short(paper: PaperResults) -> Finding:
    run = paper.run(_CONSIDERED)
    durations = np.array([end - start for start, end in run.separated_intervals])
    share = run.events.separated_time / run.t_end
    contact = (run.t_end - durations.sum()) / durations.size
    return share < 0.1, (100.0 * share, durations.max(), durations.mean(), contact)


def _crossings(paper: PaperResults, key: str) -> list[float | None]:
    # Start of the range in which Case 1 exceeds Case 2, by measure; None if there is no such range.
    ignored, considered = (line for _, line in paper.table(key).lines())
    along = considered[considered.along]
    return [crossing(along, considered[name] - ignored[name]) for name in _MEASURES]


def _check_barely_affected(paper: PaperResults, key: str) -> Finding:
    lines = [line for name in _MEASURES for line in columns(paper, key, name).values()]
    ratios = [float(line.max() / line.min()) for line in lines]
    return max(ratios[::2]) < _BARELY_RATIO and min(ratios[1::2]) > 5.0, ratios


def _check_growth(paper: PaperResults, key: str) -> Finding:
    return trend(rises, [columns(paper, key, name)[1.0] for name in _MEASURES], 0, -1)


def _check_crossings(paper: PaperResults, key: str) -> Finding:
    crossings = _crossings(paper, key)
    return None not in crossings, crossings


def _same_trends_with_stronger_nonlinearity(paper: PaperResults) -> Finding:
    constant, ratios = _check_barely_affected(paper, "14")
    grows, ends = _check_growth(paper, "14")
    cross, crossings = _check_crossings(paper, "14")
    return constant and grows and cross, (*ratios[::2], *ends, *crossings)


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
    return [(panel[0.0], panel[1.0]) for panel in panels]


def _along_stiffness(
    paper: PaperResults, case: float, rule: Callable[[FloatArray], bool]
) -> Finding:
    peaks, ranges = (
        trend(rule, [columns(paper, key, name)[case] for key in ("15", "16")], 0, -1)
        for name in _MEASURES
    )
    return peaks[0] and ranges[0], ranges[1]


def _greater_even_at_small_stiffness(paper: PaperResults) -> Finding:
    at_40, at_60 = _crossings(paper, "15"), _crossings(paper, "16")
    range_end = float(paper.table("16")["k_nl"].max())
    peaks = [line[0] for line in columns(paper, "16", "y_peak").values()]
    return _below(at_60, at_40, 0.5) and _below(at_60, [range_end] * 2, 0.1), (*at_60, *peaks)


def _amplitude_depends_on_preload(paper: PaperResults) -> Finding:
    small, large = paper.amplitudes(_PRELOAD_ALONE)
    peaks, ranges = (small.y_peak, large.y_peak), (small.y_half_range, large.y_half_range)
    return all(at_60 > 1.1 * at_40 for at_40, at_60 in (peaks, ranges)), (*peaks, *ranges)


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
    "vibration-asymmetric": lambda paper: _asymmetry(
        paper, x=static_start(System(_BASE))[0], y=static_start(System(_BASE))[2]
    ),
    "contact-force-asymmetric": lambda paper: _asymmetry(
        paper, P=equilibrium(System(_BASE), mu=0.0).P
    ),
    "separation-under-preload": compare(
        lambda paper: (
            paper.run(_CONSIDERED).events.separations,
            next((start for start, _ in paper.run(_CONSIDERED).separated_intervals), None),
        ),
        lambda count, _: count > 0,
    ),
    "reattachment-follows-separation": compare(
        lambda paper: (
            paper.run(_CONSIDERED).events.separations,
            paper.run(_CONSIDERED).events.reattachments,
        ),
        lambda separations, reattachments: 0 <= separations - reattachments <= 1,
    ),
    "separation-under-large-preload": compare(
        lambda paper: [columns(paper, key, "separations")[1.0][-1] for key in ("13", "14")],
        lambda *counts: min(counts) > 0.0,
    ),
    "separations-are-short": _separations_are_short,
    "figures-show-unstable-motion": compare(
        lambda paper: [paper.table(key)["growth_rate"].min() for key in _FIGURES],
        lambda *rates: min(rates) > 0.0,
    ),
    "ignored-barely-depends-on-preload": lambda paper: _check_barely_affected(paper, "13"),
    "considered-grows-with-preload": lambda paper: _check_growth(paper, "13"),
    "cases-cross-along-preload": lambda paper: _check_crossings(paper, "13"),
    "same-trends-with-stronger-nonlinearity": _same_trends_with_stronger_nonlinearity,
    "stronger-nonlinearity-crosses-sooner": _stronger_nonlinearity_crosses_sooner,
    "ignoring-separation-underestimates": compare(
        lambda paper: [
            (considered / ignored).max() for ignored, considered in _half_ranges(paper, *_FIGURES)
        ],
        lambda *ratios: min(ratios) > 1.0,
    ),
    "ignored-falls-with-stiffness": lambda paper: _along_stiffness(paper, 0.0, falls),
    "considered-grows-with-stiffness": lambda paper: _along_stiffness(paper, 1.0, rises),
    "cases-cross-along-stiffness": lambda paper: _check_crossings(paper, "15"),
    "greater-even-at-small-stiffness": _greater_even_at_small_stiffness,
    "amplitude-depends-on-preload": _amplitude_depends_on_preload,
    "opposite-trends": compare(
        lambda paper: [
            line[-1] - line[0] for pair in _half_ranges(paper, "15", "16") for line in pair
        ],
        lambda *changes: max(changes[::2]) < 0.0 < min(changes[1::2]),
    ),
}
SCENES: Final[Mapping[str, tuple[Scene, ...]]] = {
    "linear-contact-unbounded": _UNBOUNDED,
    "stable-seldom-separates": _STABLE,
    "stable-returns-to-equilibrium": (*_STABLE, *_ATTRACTORS),
    "amplitude-depends-on-preload": _PRELOAD_ALONE,
}

"""Claims of section 5.1: separation and reattachment during vibration."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from fivtui.model import Mode, Parameters, System, equilibrium, static_start
from fivtui.paper import PaperResults
from fivtui.scene import PRESETS
from fivtui.transient import Transient, trajectory_of

from .claim import Chapter, Finding, Quantity

TRANSIENTS: Final = Chapter()
_BASE: Final = Parameters()
_CONSIDERED: Final = PRESETS["base"]
_IGNORED: Final = PRESETS["separation-ignored"]


@TRANSIENTS.claim(
    "5.1, Fig. 10",
    "With separation ignored the contact force gradually grows and becomes negative",
    "P < 0 at times",
)
def _ignored_contact_force_becomes_negative(results: PaperResults) -> Finding:
    trajectory = trajectory_of(results.run(_IGNORED))
    negative = trajectory.P < 0.0
    first = int(np.argmax(negative))
    before = trajectory.P[:first]
    return Finding(
        bool(negative.any()) and before.size > 0,
        (
            Quantity("P at the start", trajectory.P[0], "N"),
            Quantity("greatest P before it is negative", before.max(initial=0.0), "N"),
            Quantity("negative from t", trajectory.t[first], "s"),
            Quantity("least P", trajectory.P.min(), "N"),
            Quantity("samples with P < 0", 100.0 * float(negative.mean()), "%"),
        ),
    )


@TRANSIENTS.claim(
    "5.1, Fig. 10",
    "With separation considered the contact force falls to zero, stays, and rises, many times over",
    "P ≥ 0, many separations",
)
def _contact_force_falls_to_zero_repeatedly(results: PaperResults) -> Finding:
    run = results.run(_CONSIDERED)
    return Finding(
        run.contact_force.min >= 0.0 and run.events.separations > 10,
        (
            Quantity("least P", run.contact_force.min + 0.0, "N"),
            Quantity("greatest P", run.contact_force.max, "N"),
            Quantity("separations in 100 s", run.events.separations),
        ),
    )


@TRANSIENTS.claim(
    "5.1, 5.2",
    "During separation neither contact nor friction force acts",
    "P = 0 and μ P = 0 for y > 0",
)
def _no_force_off_the_belt(results: PaperResults) -> Finding:
    trajectory = trajectory_of(results.run(_CONSIDERED))
    off = trajectory.mode == Mode.SEPARATED
    greatest = float(np.abs(trajectory.P[off]).max())
    return Finding(
        greatest == 0.0 and bool(np.all(trajectory.y[off] >= 0.0)),
        (Quantity("samples off the belt", int(off.sum())), Quantity("greatest |P|", greatest, "N")),
    )


@TRANSIENTS.claim(
    "5.2",
    "With separation ignored the stretched contact spring holds the mass back from moving up",
    "P < 0 for y > 0",
)
def _stretched_spring_holds_back(results: PaperResults) -> Finding:
    trajectory = trajectory_of(results.run(_IGNORED))
    above = trajectory.y > 0.0
    return Finding(
        bool(np.all(trajectory.P[above] < 0.0)),
        (
            Quantity("samples with y > 0", int(above.sum())),
            Quantity("least P", float(trajectory.P.min()), "N"),
            Quantity("greatest y, ignored", float(trajectory.y.max()), "m"),
            Quantity("considered", results.run(_CONSIDERED).peak.y_max, "m"),
        ),
    )


@TRANSIENTS.claim(
    "5.1, Figs. 11 and 12",
    "Separation makes the horizontal and the vertical motion different",
    "x and y differ",
)
def _separation_changes_both_motions(results: PaperResults) -> Finding:
    considered, ignored = results.run(_CONSIDERED), results.run(_IGNORED)
    ratios = (
        considered.peak.x_abs / ignored.peak.x_abs,
        considered.peak.y_abs / ignored.peak.y_abs,
    )
    return Finding(
        min(ratios) > 1.1,
        (
            Quantity("peak |x| considered", considered.peak.x_abs, "m"),
            Quantity("ignored", ignored.peak.x_abs, "m"),
            Quantity("peak |y| considered", considered.peak.y_abs, "m"),
            Quantity("ignored", ignored.peak.y_abs, "m"),
        ),
    )


@TRANSIENTS.claim(
    "5.1, Figs. 11 and 12",
    "With loss of contact the vibration is asymmetric about the original static state",
    "unequal excursions of x and y",
)
def _vibration_asymmetric(results: PaperResults) -> Finding:
    x, _, y, _ = static_start(System(_BASE))
    return _asymmetry(results.run(_CONSIDERED), {"x": x, "y": y}, "m")


@TRANSIENTS.claim(
    "5.1, Fig. 10",
    "With loss of contact the fluctuating contact force is asymmetric about its static value",
    "unequal excursions of P",
)
def _contact_force_asymmetric(results: PaperResults) -> Finding:
    return _asymmetry(results.run(_CONSIDERED), {"P": equilibrium(System(_BASE), mu=0.0).P}, "N")


def _asymmetry(run: Transient, rest: Mapping[str, float], unit: str) -> Finding:
    # Excursions in the second half of the run, after the initial transient.
    trajectory = trajectory_of(run)
    late = trajectory.t >= 0.5 * run.t_end
    quantities: list[Quantity] = []
    asymmetric = True
    for name, level in rest.items():
        values = getattr(trajectory, name)[late]
        up, down = float(values.max()) - level, level - float(values.min())
        asymmetric &= max(up, down) > 1.5 * min(up, down)
        quantities += [
            Quantity(f"{name} above its static value", up, unit),
            Quantity("below", down, unit),
        ]
    return Finding(asymmetric, tuple(quantities))


@TRANSIENTS.claim(
    "5.1", "Separation takes place in spite of the preload", "separations at F = 80 N"
)
def _separation_under_preload(results: PaperResults) -> Finding:
    run = results.run(_CONSIDERED)
    first = [Quantity("first separation at t", start, "s") for start, _ in run.separated_intervals]
    return Finding(
        run.events.separations > 0,
        (Quantity("separations in 100 s", run.events.separations), *first[:1]),
    )


@TRANSIENTS.claim("5.1", "Reattachment follows separation", "as many reattachments as separations")
def _reattachment_follows_separation(results: PaperResults) -> Finding:
    events = results.run(_CONSIDERED).events
    return Finding(
        0 <= events.separations - events.reattachments <= 1,
        (
            Quantity("separations", events.separations),
            Quantity("reattachments", events.reattachments),
        ),
        "the run ends off the belt" if events.separations > events.reattachments else "",
    )


@TRANSIENTS.claim("6", "Separation can happen even under a large preload", "separations at large F")
def _separation_under_large_preload(results: PaperResults) -> Finding:
    lines = [(key, results.table(key).line(1.0)) for key in ("13", "14")]
    return Finding(
        all(line["separations"][-1] > 0.0 for _, line in lines),
        tuple(
            Quantity(f"separations (Fig. {key}, F = {line['F'][-1]:g} N)", line["separations"][-1])
            for key, line in lines
        ),
    )


@TRANSIENTS.claim("5.1", "The separations are short", "short, so that impact matters little")
def _separations_are_short(results: PaperResults) -> Finding:
    run = results.run(_CONSIDERED)
    durations = np.array([end - start for start, end in run.separated_intervals])
    share = run.events.separated_time / run.t_end
    return Finding(
        share < 0.1,
        (
            Quantity("time off the belt of 100 s", 100.0 * share, "%"),
            Quantity("longest separation", durations.max(), "s"),
            Quantity("mean separation", durations.mean(), "s"),
            Quantity("mean contact", (run.t_end - durations.sum()) / durations.size, "s"),
        ),
        "the slider flies for most of every cycle at these parameters; that impact matters little "
        "may be true, but does not follow from this",
    )


TRANSIENTS.untestable(
    "impact-matters-little",
    "5.1",
    "Impact at reattachment influences the vibration only slightly",
    "slight influence",
    "the model has no law of impact: both fields agree at y = 0, and the velocity is continuous",
)

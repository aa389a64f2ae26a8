"""Stability verdicts and results of runs as texts and rows. Imports no Textual.

An attractor is a motion to which the slider tends: the equilibrium or a limit cycle. Below the safe
μ no disturbance was found to lead to vibration. Case 2 ignores that the slider may separate from
the belt.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, VibrationMode, critical_mu_text, margin_text, verdict
from fivtui.results import Row
from fivtui.safety import basis_rows, verdict_text
from fivtui.transient import Transient, later_amplitude

if TYPE_CHECKING:
    from fivtui.safety import SafeFriction


@dataclass(frozen=True, slots=True)
class Attractors:
    """Attractors besides the equilibrium, or the state of the search for them."""

    # What coexists with a stable equilibrium, and a warning; empty if it is unstable.
    text: str = "searching for limit cycles…"
    note: str = ""
    # Whether another attractor was found beside a stable equilibrium.
    coexists: bool = False
    # Whether the search for limit cycles has ended, and that for the safe μ, too.
    searched: bool = False
    complete: bool = False
    safe: "SafeFriction | None" = None


NO_ATTRACTORS: Final = Attractors(text="")
# By kind of verdict, the tab that leads on after a run, and its question in a word.
NEXT_STEPS: Final[Mapping[str, tuple[str, str]]] = {
    "unstable": ("branch", "safe?"),
    "coexisting": ("safe-mu", "where?"),
    "stable": ("uncertainty", "squeal?"),
}


def attractor_rows(attractors: Attractors) -> list[Row]:
    """Rows about the attractors that coexist with the equilibrium."""
    rows = [Row("coexisting", attractors.text, attractors.note)] if attractors.text else []
    if attractors.safe is not None:
        rows.append(Row("disturbances", verdict_text(attractors.safe)))
        rows += [Row(name, text) for name, text in basis_rows(attractors.safe)]
    return rows


def quantity_text(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, such as ``2070 N``."""
    text = f"{value:#.4g}".removesuffix(".") if value else "0"
    return f"{text} {unit}".rstrip()


def verdict_kind(result: Stability, attractors: Attractors | None) -> str:
    """The kind of verdict, for its colour; "stable" only if the search found no attractor."""
    if attractors is None or not attractors.text:
        return verdict(result).lower()
    if attractors.coexists:
        return "coexisting"
    return "stable" if attractors.searched else "searching"


def _mode_text(mode: VibrationMode) -> str:
    frequency = f"{mode.frequency:.4g} Hz" if mode.frequency else "aperiodic"
    return f"{frequency} {mode.growth_rate:+.3g} 1/s"


def _limit_cycle_text(safe: "SafeFriction | None") -> str:
    # The largest limit cycle around an unstable equilibrium.
    if safe is None or not safe.coexisting:
        return ""
    return f"; a limit cycle attracts: ±{quantity_text(safe.coexisting[-1].half_range, 'm')}"


def _safe_mu_text(safe: "SafeFriction | None") -> str:
    # What follows the critical μ in its line.
    if safe is None:
        return ""
    if safe.unknown_above is not None:
        # Above 0: not known at any μ.
        limit = f" above {safe.unknown_above:.4g}" if safe.unknown_above else ""
        return f" · safe μ not known{limit}"
    if safe.safe_mu is None:
        return ""
    return f" · safe below {safe.safe_mu:.4g}" if safe.others else " · no cycle found below it"


def stability_summary(result: Stability, attractors: Attractors = NO_ATTRACTORS) -> list[str]:
    """The verdict in a few lines, the most important first."""
    leading = max(result.modes, key=attrgetter("growth_rate"))
    frequency = f", {leading.frequency:.4g} Hz" if leading.frequency else ""
    growth = f"growth rate {result.growth_rate:+.4g} 1/s{frequency}"
    first_lines = [f"{verdict(result)}: {growth}{_limit_cycle_text(attractors.safe)}"]
    if attractors.text:
        conjunction = ", but" if attractors.coexists else ","
        first_lines = [f"{verdict(result)}{conjunction} {attractors.text}", growth]
    critical_mu = ", ".join(filter(None, (critical_mu_text(result, 4), margin_text(result))))
    point = result.equilibrium
    return [
        *first_lines,
        f"μ_c {critical_mu}{_safe_mu_text(attractors.safe)}",
        f"x_e {quantity_text(point.x, 'm')}  y_e {quantity_text(point.y, 'm')}  "
        f"P_e {quantity_text(point.P, 'N')}",
        "modes " + " · ".join(map(_mode_text, result.modes)),
    ]


def result_summary(run: Transient) -> list[str]:
    """The result of a run in a few short lines, the most important first."""
    peak, force, half_range = run.peak, run.contact_force, run.steady.y_half_range
    lines = [
        f"amplitude of y ±{quantity_text(half_range, 'm')}",
        _separation_text(run),
        f"P {quantity_text(force.min)} to {quantity_text(force.max, 'N')} · peak |y| "
        f"{quantity_text(peak.y_abs, 'm')}, |x| {quantity_text(peak.x_abs, 'm')}",
        _belt_text(run),
    ]
    later = later_amplitude(run)
    if later is not None:
        # A continuation of the run reaches another amplitude.
        lines[0] += f", still {'growing' if later.y_half_range > half_range else 'falling'}"
        amplitude = quantity_text(later.y_half_range, "m")
        lines.append(f"not settled: ±{amplitude} {later.after:.3g} s after the end")
    return lines


def _belt_text(run: Transient) -> str:
    # Sticks on a belt of finite speed; else the belt speed above which the slider never sticks.
    if run.parameters.v_belt is None:
        return f"valid for belts faster than {quantity_text(run.peak.vx_max, 'm/s')}"
    share = run.events.stick_time / run.t_end
    return f"{run.events.sticks} sticks · {quantity_text(run.events.stick_time, 's')} ({share:.1%})"


def _separation_text(run: Transient) -> str:
    if not run.separation:
        return "separation ignored (Case 2)"
    count, time = run.events.separations, run.events.separated_time
    if time == 0.0:
        return "no separation: contact is never lost"
    counted = "1 separation" if count == 1 else f"{count} separations"
    return f"{counted} · off belt {quantity_text(time, 's')} ({100.0 * time / run.t_end:.3g} %)"


def late_separation_warning(run: Transient, result: Stability) -> str:
    """A warning if a run still separates although the equilibrium is stable; else empty."""
    time = run.events.last
    if result.stable and time is not None and time > 0.5 * run.t_end:
        return f"stable equilibrium, but still separating at t = {quantity_text(time, 's')}"
    return ""

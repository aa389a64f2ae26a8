"""Stability verdicts and results of runs as texts and rows. Imports no Textual."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, critical_mu_text, margin_text, verdict
from fivtui.results import Row
from fivtui.safety import basis_rows, verdict_text
from fivtui.transient import Transient, later_amplitude

if TYPE_CHECKING:
    from fivtui.safety import SafeFriction

SEARCHING_TEXT: Final = "searching for limit cycles…"


@dataclass(frozen=True, slots=True)
class Attractors:
    """Attractors besides the equilibrium, or the state of the search for them."""

    text: str = SEARCHING_TEXT
    note: str = ""
    coexists: bool = False
    searched: bool = False  # the search for limit cycles has ended
    safe: "SafeFriction | None" = None
    complete: bool = False  # the search for safe μ has ended, too


def attractor_rows(attractors: Attractors) -> list[Row]:
    """Rows about the attractors that coexist with the equilibrium."""
    rows = [Row("coexisting", attractors.text, attractors.note)] if attractors.text else []
    if attractors.safe is not None:
        rows.append(Row("disturbances", verdict_text(attractors.safe)))
        rows += [Row(name, text) for name, text in basis_rows(attractors.safe)]
    return rows


def quantity(value: float, unit: str = "") -> str:
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


# Label of the half range of y.
HALF_RANGE_LABEL: Final = "±y, 2nd half of run"


def _distinct_eigenvalues(result: Stability) -> list[complex]:
    # One eigenvalue of each conjugate pair, and all real ones.
    return [complex(value) for value in result.eigenvalues if value.imag >= 0.0]


def _mode_text(value: complex) -> str:
    rate = f"{value.real:+.3g} 1/s"
    if value.imag == 0.0:
        return f"aperiodic {rate}"
    return f"{value.imag / math.tau:.4g} Hz {rate}"


def _limit_cycle_text(attractors: Attractors) -> str:
    # The limit cycle around an unstable equilibrium.
    if attractors.safe is None or not attractors.safe.coexisting:
        return ""
    return f"; a limit cycle attracts: ±{quantity(attractors.safe.coexisting[-1].half_range, 'm')}"


def _safe_mu_text(attractors: Attractors | None) -> str:
    if attractors is None or attractors.safe is None:
        return ""
    if attractors.safe.unknown_above is not None:
        above = attractors.safe.unknown_above
        return f" · safe μ not known{f' above {above:.4g}' if above else ''}"
    if attractors.safe.safe_mu is None:
        return ""
    if not attractors.safe.others:
        return " · no cycle found below it"
    return f" · safe below {attractors.safe.safe_mu:.4g}"


def stability_summary(result: Stability, attractors: Attractors | None = None) -> list[str]:
    """The verdict in a few lines, the most important first."""
    point, margin = result.equilibrium, margin_text(result)
    leading = max(_distinct_eigenvalues(result), key=lambda value: value.real)
    frequency = f", {leading.imag / math.tau:.4g} Hz" if leading.imag else ""
    growth = f"growth rate {result.growth_rate:+.4g} 1/s{frequency}"
    headline = [f"{verdict(result)}: {growth}"]
    if attractors is not None and not attractors.text:
        headline = [f"{headline[0]}{_limit_cycle_text(attractors)}"]
    elif attractors is not None:
        conjunction = ", but" if attractors.coexists else ","
        headline = [f"{verdict(result)}{conjunction} {attractors.text}", growth]
    return [
        *headline,
        f"μ_c {critical_mu_text(result, 4)}{margin and ', '}{margin}{_safe_mu_text(attractors)}",
        f"x_e {quantity(point.x, 'm')}  y_e {quantity(point.y, 'm')}  P_e {quantity(point.P, 'N')}",
        "modes " + " · ".join(_mode_text(value) for value in _distinct_eigenvalues(result)),
    ]


def result_summary(run: Transient) -> list[str]:
    """The result of a run in a few short lines, the most important first."""
    peak, force, later = run.peak, run.contact_force, later_amplitude(run)
    settling_lines = []
    if later is not None:
        amplitude = quantity(later.y_half_range, "m")
        settling_lines = [f"not settled: ±{amplitude} {later.after:.3g} s after the end"]
    return [
        f"peak |y| {quantity(peak.y_abs, 'm')} · 2nd half ±{quantity(run.steady.y_half_range, 'm')}"
        f"{' unsettled' if settling_lines else ''}",
        _separation_text(run),
        f"P {quantity(force.min)} to {quantity(force.max, 'N')} · peak |x| "
        f"{quantity(peak.x_abs, 'm')}",
        _belt_text(run),
        *settling_lines,
    ]


def _belt_text(run: Transient) -> str:
    if run.parameters.v_belt is None:
        return f"valid for belts faster than {quantity(run.peak.vx_max, 'm/s')}"
    share = run.events.stick_time / run.t_end
    return f"{run.events.sticks} sticks · {quantity(run.events.stick_time, 's')} ({share:.1%})"


def _separation_text(run: Transient) -> str:
    if not run.separation:
        return "separation ignored (Case 2)"
    if run.events.separated_time == 0.0:
        return "no separation: contact is never lost"
    share = 100.0 * run.events.separated_time / run.t_end
    noun = "separation" if run.events.separations == 1 else "separations"
    return (
        f"{run.events.separations} {noun} · off belt "
        f"{quantity(run.events.separated_time, 's')} ({share:.3g} %)"
    )


def late_separation_warning(run: Transient, result: Stability) -> str:
    """A warning if a run still separates although the equilibrium is stable; else empty."""
    last_separation = run.events.last
    if result.stable and last_separation is not None and last_separation > 0.5 * run.t_end:
        return f"stable equilibrium, but still separating at t = {quantity(last_separation, 's')}"
    return ""

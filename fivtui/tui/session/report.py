"""Stability verdicts and results of runs as texts and rows. Imports no Textual."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, critical_mu_text, margin_text, verdict
from fivtui.orbits import SEARCHING_TEXT
from fivtui.results import Row
from fivtui.safety import basis_rows, verdict_text
from fivtui.transient import Transient, later_amplitude

if TYPE_CHECKING:
    from fivtui.safety import SafeFriction


@dataclass(frozen=True, slots=True)
class Attractors:
    """State and results of the search for attractors that coexist with the equilibrium."""

    text: str = SEARCHING_TEXT
    note: str = ""
    coexists: bool = False
    complete: bool = False
    safe: "SafeFriction | None" = None
    searched: bool = False


def attractor_rows(search: Attractors) -> list[Row]:
    """Rows about the attractors that coexist with the equilibrium."""
    rows = [Row("coexisting", search.text, search.note)] if search.text else []
    if search.safe is not None:
        rows.append(Row("disturbances", verdict_text(search.safe)))
        rows += [Row(name, text) for name, text in basis_rows(search.safe)]
    return rows


def quantity(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, such as ``2070 N``."""
    text = f"{value:#.4g}".removesuffix(".") if value else "0"
    return f"{text} {unit}".rstrip()


def verdict_kind(result: Stability, search: Attractors | None) -> str:
    """The kind of verdict, for its colour; "stable" only if the search found no attractor."""
    if search is None or not search.text:
        return verdict(result).lower()
    if search.coexists:
        return "coexisting"
    return "stable" if search.complete else "searching"


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


def _limit_cycle_text(search: Attractors) -> str:
    # The limit cycle around an unstable equilibrium.
    if search.safe is None or not search.safe.coexisting:
        return ""
    return f"; a limit cycle attracts: ±{quantity(search.safe.coexisting[-1].half_range, 'm')}"


def _safe_mu_text(search: Attractors | None) -> str:
    if search is None or search.safe is None:
        return ""
    if search.safe.unknown_above is not None:
        above = search.safe.unknown_above
        return f" · safe μ not known{f' above {above:.4g}' if above else ''}"
    if search.safe.safe_mu is None:
        return ""
    if not search.safe.others:
        return " · no cycle found below it"
    return f" · safe below {search.safe.safe_mu:.4g}"


def stability_summary(result: Stability, search: Attractors | None = None) -> list[str]:
    """The verdict in a few lines, the most important first."""
    point, margin = result.equilibrium, margin_text(result)
    leading = max(_distinct_eigenvalues(result), key=lambda value: value.real)
    frequency = f", {leading.imag / math.tau:.4g} Hz" if leading.imag else ""
    growth = f"growth rate {result.growth_rate:+.4g} 1/s{frequency}"
    headline = [f"{verdict(result)}: {growth}"]
    if search is not None and not search.text:
        headline = [f"{headline[0]}{_limit_cycle_text(search)}"]
    elif search is not None:
        conjunction = ", but" if search.coexists else ","
        headline = [f"{verdict(result)}{conjunction} {search.text}", growth]
    return [
        *headline,
        f"μ_c {critical_mu_text(result, 4)}{margin and ', '}{margin}{_safe_mu_text(search)}",
        f"x_e {quantity(point.x, 'm')}  y_e {quantity(point.y, 'm')}  P_e {quantity(point.P, 'N')}",
        "modes " + " · ".join(_mode_text(value) for value in _distinct_eigenvalues(result)),
    ]


def result_summary(run: Transient) -> list[str]:
    """The result of a run in a few short lines, the most important first."""
    peak, force, settling = run.peak, run.contact_force, later_amplitude(run)
    settling_lines = []
    if settling is not None:
        amplitude = quantity(settling.y_half_range, "m")
        settling_lines = [f"not settled: ±{amplitude} {settling.after:.3g} s after the end"]
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

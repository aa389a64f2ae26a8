"""Verdicts and results as text and rows. Imports no Textual."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, critical_mu_text, margin_text, verdict
from fivtui.orbits import SEARCHING_TEXT
from fivtui.results import Row
from fivtui.safety import basis_rows, safety_words
from fivtui.transient import Transient, later_amplitude

if TYPE_CHECKING:
    from fivtui.safety import SafeFriction


@dataclass(frozen=True, slots=True)
class AttractorSearch:
    """State of the search for attractors beside the equilibrium."""

    text: str = SEARCHING_TEXT
    note: str = ""
    coexists: bool = False
    complete: bool = False
    safe: "SafeFriction | None" = None
    searched: bool = False


def attractor_rows(coexisting: AttractorSearch) -> list[Row]:
    """The attractors beside the equilibrium, as rows."""
    rows = [Row("coexisting", coexisting.text, coexisting.note)] if coexisting.text else []
    if coexisting.safe is not None:
        rows.append(Row("disturbances", safety_words(coexisting.safe)))
        rows += [Row(name, text) for name, text in basis_rows(coexisting.safe)]
    return rows


def quantity(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, such as ``2070 N``."""
    text = f"{value:#.4g}".removesuffix(".") if value else "0"
    return f"{text} {unit}".rstrip()


def verdict_kind(s: Stability, coexisting: AttractorSearch | None) -> str:
    """The kind of verdict for colouring; "stable" only if no other attractor was found."""
    if coexisting is None or not coexisting.text:
        return verdict(s).lower()
    if coexisting.coexists:
        return "coexisting"
    return "stable" if coexisting.complete else "searching"


# Short name of the half peak-to-peak of y.
HALF_RANGE_LABEL: Final = "±y, 2nd half of run"


def _modes(s: Stability) -> list[complex]:
    # One eigenvalue of each conjugate pair, and all real ones.
    return [complex(value) for value in s.eigenvalues if value.imag >= 0.0]


def _mode_words(value: complex) -> str:
    rate = f"{value.real:+.3g} 1/s"
    if value.imag == 0.0:
        return f"aperiodic {rate}"
    return f"{value.imag / math.tau:.4g} Hz {rate}"


def _attracting(coexisting: AttractorSearch) -> str:
    # The limit cycle that attracts near an unstable equilibrium.
    if coexisting.safe is None or not coexisting.safe.coexisting:
        return ""
    return f"; a limit cycle attracts: ±{quantity(coexisting.safe.coexisting[-1].half_range, 'm')}"


def _safe(coexisting: AttractorSearch | None) -> str:
    if coexisting is None or coexisting.safe is None:
        return ""
    if coexisting.safe.unknown_above is not None:
        above = coexisting.safe.unknown_above
        return f" · safe μ not known{f' above {above:.4g}' if above else ''}"
    if coexisting.safe.safe_mu is None:
        return ""
    if not coexisting.safe.others:
        return " · no cycle found below it"
    return f" · safe below {coexisting.safe.safe_mu:.4g}"


def stability_summary(s: Stability, coexisting: AttractorSearch | None = None) -> list[str]:
    """The verdict in a few lines, the most important first."""
    point, margin = s.equilibrium, margin_text(s)
    leading = max(_modes(s), key=lambda value: value.real)
    frequency = f", {leading.imag / math.tau:.4g} Hz" if leading.imag else ""
    growth = f"growth rate {s.growth_rate:+.4g} 1/s{frequency}"
    head = [f"{verdict(s)}: {growth}"]
    if coexisting is not None and not coexisting.text:
        head = [f"{head[0]}{_attracting(coexisting)}"]
    elif coexisting is not None:
        link = ", but" if coexisting.coexists else ","
        head = [f"{verdict(s)}{link} {coexisting.text}", growth]
    return [
        *head,
        f"μ_c {critical_mu_text(s, 4)}{margin and ', '}{margin}{_safe(coexisting)}",
        f"x_e {quantity(point.x, 'm')}  y_e {quantity(point.y, 'm')}  P_e {quantity(point.P, 'N')}",
        "modes " + " · ".join(_mode_words(value) for value in _modes(s)),
    ]


def result_summary(r: Transient) -> list[str]:
    """A transient in a few short lines, the most important first."""
    peak, force, later = r.peak, r.contact_force, later_amplitude(r)
    settling = []
    if later is not None:
        amplitude = quantity(later.y_half_range, "m")
        settling = [f"not settled: ±{amplitude} {later.after:.3g} s after the end"]
    return [
        f"peak |y| {quantity(peak.y_abs, 'm')} · 2nd half ±{quantity(r.steady.y_half_range, 'm')}"
        f"{' unsettled' if settling else ''}",
        _separation_words(r),
        f"P {quantity(force.min)} to {quantity(force.max, 'N')} · peak |x| "
        f"{quantity(peak.x_abs, 'm')}",
        _belt_words(r),
        *settling,
    ]


def _belt_words(r: Transient) -> str:
    if r.parameters.v_belt is None:
        return f"valid for belts faster than {quantity(r.peak.vx_max, 'm/s')}"
    share = r.events.stick_time / r.t_end
    return f"{r.events.sticks} sticks · {quantity(r.events.stick_time, 's')} ({share:.1%})"


def _separation_words(r: Transient) -> str:
    if not r.separation:
        return "separation ignored (Case 2)"
    if r.events.separated_time == 0.0:
        return "no separation: contact is never lost"
    share = 100.0 * r.events.separated_time / r.t_end
    noun = "separation" if r.events.separations == 1 else "separations"
    return (
        f"{r.events.separations} {noun} · off belt "
        f"{quantity(r.events.separated_time, 's')} ({share:.3g} %)"
    )


def late_separation_warning(r: Transient, s: Stability) -> str:
    """A warning that a run still separates although the equilibrium is stable; else empty."""
    last_separation = r.events.last
    if s.stable and last_separation is not None and last_separation > 0.5 * r.t_end:
        return f"stable equilibrium, but still separating at t = {quantity(last_separation, 's')}"
    return ""

"""Verdicts and results in words and rows. Imports no Textual."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, critical_mu_text, margin_text, verdict
from fivtui.orbits import SEARCHING
from fivtui.results import Row
from fivtui.safety import basis_rows, safety_words
from fivtui.transient import Transient, later_amplitude

if TYPE_CHECKING:
    from fivtui.safety import SafeFriction


@dataclass(frozen=True, slots=True)
class Coexisting:
    """What is known of attractors beside the equilibrium."""

    words: str = SEARCHING
    note: str = ""
    coexists: bool = False
    done: bool = False
    safe: "SafeFriction | None" = None
    searched: bool = False


def coexisting_rows(known: Coexisting) -> list[Row]:
    """What is known of attractors beside the equilibrium: label, value, and a note."""
    rows = [Row("coexisting", known.words, known.note)] if known.words else []
    if known.safe is not None:
        rows.append(Row("disturbances", safety_words(known.safe)))
        rows += [Row(name, said) for name, said in basis_rows(known.safe)]
    return rows


def quantity(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, such as ``2070 N``."""
    text = f"{value:#.4g}".removesuffix(".") if value else "0"
    return f"{text} {unit}".rstrip()


def verdict_kind(s: Stability, coexisting: Coexisting | None) -> str:
    """The kind of verdict for colouring; "stable" only if no other attractor was found."""
    if coexisting is None or not coexisting.words:
        return verdict(s).lower()
    if coexisting.coexists:
        return "coexisting"
    return "stable" if coexisting.done else "searching"


# Short name of the half peak-to-peak of y.
SECOND_HALF: Final = "±y, 2nd half of run"


def _modes(s: Stability) -> list[complex]:
    # One of each conjugate pair, and the real ones.
    return [complex(value) for value in s.eigenvalues if value.imag >= 0.0]


def _mode_words(value: complex) -> str:
    rate = f"{value.real:+.3g} 1/s"
    if value.imag == 0.0:
        return f"aperiodic {rate}"
    return f"{value.imag / math.tau:.4g} Hz {rate}"


def _attracting(known: Coexisting) -> str:
    # The cycle that an unstable equilibrium leaves for.
    if known.safe is None or not known.safe.coexisting:
        return ""
    return f"; a limit cycle attracts: ±{quantity(known.safe.coexisting[-1].half_range, 'm')}"


def _safe(known: Coexisting | None) -> str:
    if known is None or known.safe is None:
        return ""
    if known.safe.unknown_above is not None:
        above = known.safe.unknown_above
        return f" · safe μ not known{f' above {above:.4g}' if above else ''}"
    if known.safe.safe_mu is None:
        return ""
    if not known.safe.others:
        return " · no cycle found below it"
    return f" · safe below {known.safe.safe_mu:.4g}"


def stability_brief(s: Stability, coexisting: Coexisting | None = None) -> list[str]:
    """The verdict in a few lines, the most important first."""
    point, margin = s.equilibrium, margin_text(s)
    leading = max(_modes(s), key=lambda value: value.real)
    frequency = f", {leading.imag / math.tau:.4g} Hz" if leading.imag else ""
    growth = f"growth rate {s.growth_rate:+.4g} 1/s{frequency}"
    head = [f"{verdict(s)}: {growth}"]
    if coexisting is not None and not coexisting.words:
        head = [f"{head[0]}{_attracting(coexisting)}"]
    elif coexisting is not None:
        link = ", but" if coexisting.coexists else ","
        head = [f"{verdict(s)}{link} {coexisting.words}", growth]
    return [
        *head,
        f"μ_c {critical_mu_text(s, 4)}{margin and ', '}{margin}{_safe(coexisting)}",
        f"x_e {quantity(point.x, 'm')}  y_e {quantity(point.y, 'm')}  P_e {quantity(point.P, 'N')}",
        "modes " + " · ".join(_mode_words(value) for value in _modes(s)),
    ]


def result_brief(r: Transient) -> list[str]:
    """A transient in a few short lines, the most important first; one of its settling last."""
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


def remark(r: Transient, s: Stability) -> str:
    """A warning that a run still separates although the equilibrium is stable; else empty."""
    last = r.events.last
    if s.stable and last is not None and last > 0.5 * r.t_end:
        return f"stable equilibrium, but still separating at t = {quantity(last, 's')}"
    return ""

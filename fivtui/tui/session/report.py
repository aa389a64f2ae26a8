"""Verdicts and results in words and rows. Imports no Textual."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.equilibrium import Stability
from fivtui.model import Mode, Parameters
from fivtui.orbits import SEARCHING
from fivtui.results import Row
from fivtui.transient import Transient

# Growth rates below this part of the largest eigenvalue count as zero.
_NEUTRAL: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Coexisting:
    """Attractors found beside a stable equilibrium.

    Attributes
    ----------
    words, note : str
        What was found, and a remark.
    coexists : bool
        Whether an attractor was found.
    done : bool
        Whether the search has finished.
    """

    words: str = SEARCHING
    note: str = ""
    coexists: bool = False
    done: bool = False


def quantity(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, such as ``2070 N``."""
    text = f"{value:#.4g}".removesuffix(".") if value else "0"
    return f"{text} {unit}".rstrip()


def verdict(s: Stability) -> str:
    """The stability of the equilibrium: ``STABLE``, ``UNSTABLE`` or ``NEUTRAL``."""
    if s.stable:
        return "STABLE"
    neutral = abs(s.growth_rate) <= _NEUTRAL * float(np.abs(s.eigenvalues).max())
    return "NEUTRAL" if neutral else "UNSTABLE"


def verdict_kind(s: Stability, coexisting: Coexisting | None) -> str:
    """The kind of verdict for colouring; "stable" only if no other attractor was found."""
    if coexisting is None:
        return verdict(s).lower()
    if coexisting.coexists:
        return "coexisting"
    return "stable" if coexisting.done else "searching"


# Short name of the half peak-to-peak of y.
SECOND_HALF: Final = "±y, 2nd half of run"

_CONSEQUENCE: Final = {
    "STABLE": "small disturbances die out",
    "UNSTABLE": "small disturbances grow (flutter)",
    "NEUTRAL": "small disturbances neither grow nor die out",
}


def _modes(s: Stability) -> list[complex]:
    # One of each conjugate pair, and the real ones.
    return [complex(value) for value in s.eigenvalues if value.imag >= 0.0]


def _mode_words(value: complex) -> str:
    rate = f"{value.real:+.3g} 1/s"
    if value.imag == 0.0:
        return f"aperiodic {rate}"
    return f"{value.imag / math.tau:.4g} Hz {rate}"


def _critical_words(s: Stability) -> str:
    if not s.critical_mu:
        return "none for μ > 0"
    return ", ".join(f"{quantity(c.mu)} ({c.becomes} above)" for c in s.critical_mu)


def _margin(p: Parameters, s: Stability) -> str:
    if not s.critical_mu:
        return ""
    nearest = min((c.mu for c in s.critical_mu), key=lambda mu: abs(mu - p.mu))
    part = p.mu / nearest - 1.0
    side = "above" if part > 0.0 else "below"
    return f"μ {100.0 * abs(part):.3g} % {side}"


def stability_brief(p: Parameters, s: Stability, coexisting: Coexisting | None = None) -> list[str]:
    """The verdict in a few lines, the most important first."""
    point, margin = s.equilibrium, _margin(p, s)
    leading = max(_modes(s), key=lambda value: value.real)
    frequency = f", {leading.imag / math.tau:.4g} Hz" if leading.imag else ""
    growth = f"growth rate {s.growth_rate:+.4g} 1/s{frequency}"
    head = [f"{verdict(s)}: {growth}"]
    if coexisting is not None:
        link = ", but" if coexisting.coexists else ","
        head = [f"{verdict(s)}{link} {coexisting.words}", growth]
    return [
        *head,
        f"μ_c {_critical_words(s)}{margin and ', '}{margin}",
        f"x_e {quantity(point.x, 'm')}  y_e {quantity(point.y, 'm')}  P_e {quantity(point.P, 'N')}",
        "modes " + " · ".join(_mode_words(value) for value in _modes(s)),
    ]


def stability_rows(p: Parameters, s: Stability, coexisting: Coexisting | None = None) -> list[Row]:
    """All results of a stability analysis."""
    point = s.equilibrium
    rows = [
        Row("verdict", verdict(s), _CONSEQUENCE[verdict(s)]),
        *([] if coexisting is None else [Row("coexisting", coexisting.words, coexisting.note)]),
        Row("growth rate", f"{s.growth_rate:+.6g} 1/s", _time_scale(s.growth_rate)),
        Row("critical μ", _critical_words(s), _margin(p, s)),
        Row(
            "critical μ, linear",
            "none" if s.linear_critical_mu is None else quantity(s.linear_critical_mu),
            "of the system with k_nl = 0",
        ),
        Row("equilibrium x", f"{point.x:.6g} m", "Eq. 6"),
        Row("equilibrium y", f"{point.y:.6g} m", "negative: contact is compressed"),
        Row(
            "contact force",
            f"{point.P:.6g} N",
            "in contact" if point.mode is Mode.CONTACT else "separated: the preload lifts it off",
        ),
    ]
    near = s.coalescence
    merged = near.frequency_distance <= _NEUTRAL * float(np.abs(s.eigenvalues).max())
    apart = "0: coalesced" if merged else quantity(near.frequency_distance / math.tau, "Hz")
    meet = "nowhere" if near.mu is None else f"at μ {quantity(near.mu)}"
    rows.append(Row("frequency distance", apart, f"undamped, the modes coalesce {meet}"))
    for number, value in enumerate(_modes(s), start=1):
        damping = f"damping ratio {-value.real / abs(value):+.3g}" if value else ""
        rows.append(Row(f"eigenvalue {number}", _eigenvalue(value), damping))
        if value.imag:
            rows.append(Row(f"frequency {number}", f"{value.imag / math.tau:.6g} Hz"))
    return rows


def _eigenvalue(value: complex) -> str:
    imaginary = f" ± {value.imag:.6g}i" if value.imag else ""
    return f"{value.real:+.6g}{imaginary} 1/s"


def _time_scale(rate: float) -> str:
    if rate == 0.0:
        return ""
    change = "doubles" if rate > 0.0 else "halves"
    return f"amplitude {change} every {math.log(2.0) / abs(rate):.4g} s"


def result_brief(r: Transient) -> list[str]:
    """A transient in four short lines, the most important first."""
    peak, force = r.peak, r.contact_force
    return [
        f"peak |y| {quantity(peak.y_abs, 'm')} · 2nd half of run "
        f"±{quantity(r.steady.y_half_range, 'm')}",
        _separation_words(r),
        f"P {quantity(force.min)} to {quantity(force.max, 'N')} · peak |x| "
        f"{quantity(peak.x_abs, 'm')}",
        f"valid for belts faster than {quantity(peak.vx_max, 'm/s')}",
    ]


def _separation_words(r: Transient) -> str:
    if not r.separation:
        return "separation ignored (Case 2)"
    if r.events.separated_time == 0.0:
        return "no separation: contact is never lost"
    share = 100.0 * r.events.separated_time / r.t_end
    noun = "separation" if r.events.separations == 1 else "separations"
    return (
        f"{r.events.separations} {noun} · off the belt "
        f"{quantity(r.events.separated_time, 's')} ({share:.3g} %)"
    )


def result_rows(r: Transient, accuracy: str) -> list[Row]:
    """All results of a transient; `accuracy` is its requested accuracy in words."""
    peak, events, force, final = r.peak, r.events, r.contact_force, r.final
    above = "above 0: off the belt" if r.separation else "above 0: contact in tension"
    rows = [
        Row("peak |y|", quantity(peak.y_abs, "m"), "exact, between samples too"),
        Row("range of y", f"{quantity(peak.y_min)} to {quantity(peak.y_max, 'm')}", above),
        Row("peak |x|", quantity(peak.x_abs, "m")),
        Row(
            "half peak-to-peak of y",
            quantity(r.steady.y_half_range, "m"),
            "over the second half of the run",
        ),
        Row("contact force", f"{quantity(force.min)} to {quantity(force.max, 'N')}"),
        Row("separation", "considered" if r.separation else "ignored", _separation_words(r)),
    ]
    if events.first is not None and events.last is not None:
        rows += [
            Row("reattachments", str(events.reattachments)),
            Row("first switch", quantity(events.first, "s")),
            Row("last switch", quantity(events.last, "s")),
        ]
    rows += [
        Row(
            "max ẋ",
            quantity(peak.vx_max, "m/s"),
            "the model is valid for faster belts only",
        ),
        Row("final x", f"{final.x:.9g} m", f"t = {final.t:g} s"),
        Row("final ẋ", f"{final.vx:.9g} m/s"),
        Row("final y", f"{final.y:.9g} m"),
        Row("final ẏ", f"{final.vy:.9g} m/s"),
        Row("method", r.method, accuracy),
        Row("steps", str(r.stats.steps)),
    ]
    if r.stats.cpu_s is not None:
        rows.append(Row("CPU time", quantity(r.stats.cpu_s, "s")))
    return rows


def remark(r: Transient, s: Stability) -> str:
    """A warning that a run still separates although the equilibrium is stable; else empty."""
    last = r.events.last
    if s.stable and last is not None and last > 0.5 * r.t_end:
        return f"stable equilibrium, but still separating at t = {quantity(last, 's')}"
    return ""

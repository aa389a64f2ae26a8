"""The rows of reports on stability, in the laboratory and on the command line."""

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from fivtui.console import number, parameter_line, print_list
from fivtui.model import IN_CONTACT, sliding_coefficients
from fivtui.results import Row

from .eigenvalues import Stability

if TYPE_CHECKING:
    from fivtui.model import Equilibrium

    from .modes import VibrationMode


# Growth rates below this fraction of the largest eigenvalue count as zero.
_ZERO_SHARE: Final = 1e-9
_CONSEQUENCE: Final = {
    "STABLE": "small disturbances die out",
    "UNSTABLE": "small disturbances grow (flutter)",
    "NEUTRAL": "small disturbances neither grow nor die out",
}


def verdict(result: Stability) -> str:
    """The stability of the equilibrium: ``STABLE``, ``UNSTABLE`` or ``NEUTRAL``."""
    if result.stable:
        return "STABLE"
    return "NEUTRAL" if abs(result.growth_rate) <= _zero_growth(result) else "UNSTABLE"


def _zero_growth(result: Stability) -> float:
    # Growth rates and distances of frequencies up to this one, 1/s, count as zero.
    return _ZERO_SHARE * float(np.abs(result.eigenvalues).max())


def critical_mu_text(result: Stability, digits: int = 6) -> str:
    """The critical friction coefficients, and what the equilibrium becomes above each."""
    if not result.critical_mu:
        return "none for μ > 0"
    return ", ".join(f"{number(c.mu, digits)} ({c.becomes} above)" for c in result.critical_mu)


def margin_text(result: Stability) -> str:
    """Relative distance of μ from the nearest critical μ; empty without one."""
    if not result.critical_mu:
        return ""
    mu = result.parameters.mu
    excess = mu / min((c.mu for c in result.critical_mu), key=lambda value: abs(value - mu)) - 1.0
    return f"μ {100.0 * abs(excess):.3g} % {'above' if excess > 0.0 else 'below'}"


def stability_rows(result: Stability) -> list[Row]:
    """All results of a stability analysis: label, value with unit, and a note."""
    point, coalescence, linear = result.equilibrium, result.coalescence, result.linear_critical_mu
    distance, margin_mu = coalescence.frequency_distance, result.margin.mu
    margin = "" if margin_mu is None else f"{margin_text(result)}, margin {margin_mu:+.6g}"
    coalescence_text = "nowhere" if coalescence.mu is None else f"at μ {number(coalescence.mu)}"
    rows = [
        Row("verdict", verdict(result), _CONSEQUENCE[verdict(result)]),
        Row("growth rate", f"{result.growth_rate:+.6g} 1/s", _time_scale_text(result)),
        Row("critical μ", critical_mu_text(result), margin),
        Row(
            "critical μ, linear",
            "none" if linear is None else number(linear),
            "of the system with k_nl = 0",
        ),
        *_belt_rows(result),
        Row("equilibrium x", f"{number(point.x)} m", "Eq. 6 of the paper"),
        Row("equilibrium y", f"{number(point.y)} m", _height_text(point)),
        Row(
            "contact force",
            f"{number(point.P)} N",
            "in contact" if point.mode in IN_CONTACT else "off the belt: F < 0 lifts the slider",
        ),
        Row(
            "frequency distance",
            "0: coalesced"
            if distance <= _zero_growth(result)
            else f"{number(distance / math.tau)} Hz",
            f"undamped, the modes coalesce {coalescence_text}",
        ),
    ]
    rows += [
        Row(f"eigenvalue {index}", _eigenvalue_text(value))
        for index, value in enumerate((v for v in result.eigenvalues.tolist() if v.imag >= 0.0), 1)
    ]
    rows += [
        Row(
            f"mode {index}",
            f"{number(mode.frequency)} Hz",
            f"damping ratio {number(mode.damping_ratio, 4)}, {_shape_text(mode)}",
        )
        for index, mode in enumerate(result.modes, 1)
    ]
    return rows


def _height_text(point: "Equilibrium") -> str:
    # What the sign of y means.
    if point.y < 0.0:
        return "negative: contact is compressed"
    if point.y > 0.0:
        in_contact = point.mode in IN_CONTACT
        return "positive: " + ("contact is stretched" if in_contact else "above the belt")
    return "zero: contact without force"


def _belt_rows(result: Stability) -> list[Row]:
    # Rows for a belt of finite speed.
    if result.parameters.v_belt is None:
        return []
    mu, c1 = sliding_coefficients(result.parameters, result.equilibrium.y, result.equilibrium.mode)
    faster = "above" if result.parameters.v_belt >= 0.0 else "below"
    speeds = ", ".join(
        f"{number(c.v_belt)} m/s ({c.becomes} {faster})" for c in result.critical_speed
    )
    return [
        Row("critical belt speed", speeds or "none"),
        Row("μ at the belt's speed", number(mu), f"horizontal damping {number(c1)} N s/m"),
    ]


def _eigenvalue_text(value: complex) -> str:
    imaginary = f" ± {value.imag:.6g}i" if value.imag else ""
    return f"{value.real:+.6g}{imaginary} 1/s"


def _time_scale_text(result: Stability) -> str:
    rate = result.growth_rate
    if verdict(result) == "NEUTRAL":
        return "zero within rounding"
    change = "doubles" if rate > 0.0 else "halves"
    return f"amplitude {change} every {math.log(2.0) / abs(rate):.4g} s"


def _shape_text(mode: "VibrationMode") -> str:
    # Vertical over horizontal amplitude, and phase lead of y over x.
    x, y = mode.shape
    if x == 0.0:
        return "vertical motion alone"
    ratio = y / x
    degrees = round(math.degrees(math.atan2(ratio.imag, ratio.real)), 6) + 0.0
    return f"y/x {number(abs(ratio), 4)}, {number(degrees, 4)}°"


def print_stability(result: Stability) -> None:
    """Print the report of a stability analysis."""
    parameters = Row("parameters", parameter_line(result.parameters))
    print_list("Stability", [parameters, *stability_rows(result)])

"""Console output of stability and stability maps."""

import math
from typing import TYPE_CHECKING

import numpy as np

from fivtui.console import number, parameter_line, print_list
from fivtui.model import PARAMETERS

from .eigenvalues import Stability
from .files import MAP_COLUMNS

if TYPE_CHECKING:
    from .map import StabilityMap
    from .modes import VibrationMode


def print_stability(verdict: Stability) -> None:
    """Print equilibrium, eigenvalues and critical friction coefficients."""
    point = verdict.equilibrium
    rows = [
        ("parameters", parameter_line(verdict.parameters)),
        (
            "equilibrium",
            f"x={number(point.x)} m  y={number(point.y)} m  P={number(point.P)} N",
        ),
        ("verdict", "stable" if verdict.stable else "unstable"),
        ("growth rate", f"{number(verdict.growth_rate)} 1/s"),
    ]
    rows += [
        ("eigenvalue", f"{number(value.real)} {value.imag:+.6g}i 1/s")
        for value in verdict.eigenvalues.tolist()
    ]
    rows += [
        (
            "mode",
            f"{number(mode.frequency)} Hz  ({number(mode.angular_frequency)} rad/s)  "
            f"damping ratio {number(mode.damping_ratio)}  {_shape(mode)}",
        )
        for mode in verdict.modes
    ]
    rows += [
        ("critical friction coefficient", f"{number(c.mu)}  ({c.becomes} above)")
        for c in verdict.critical_mu
    ] or [("critical friction coefficient", "none")]
    linear = verdict.linear_critical_mu
    rows.append(("  of the linear system", "none" if linear is None else number(linear)))
    left = verdict.margin.mu
    rows.append(("margin in friction coefficient", "none" if left is None else f"{left:+.6g}"))
    near = verdict.coalescence
    meet = "nowhere" if near.mu is None else f"at friction coefficient {number(near.mu)}"
    rows += [
        ("distance between the frequencies", f"{number(near.frequency_distance)} rad/s"),
        ("undamped frequencies coalesce", meet),
    ]
    print_list("Stability", rows)


def _shape(mode: "VibrationMode") -> str:
    # Vertical over horizontal amplitude, and phase lead of y over x.
    x, y = mode.shape
    if x == 0.0:
        return "vertical motion alone"
    ratio = y / x
    degrees = round(math.degrees(math.atan2(ratio.imag, ratio.real)), 6) + 0.0
    return f"y/x {number(abs(ratio))}, {number(degrees, 4)}°"


def print_map(result: "StabilityMap") -> None:
    """Print a map's size, range of values and unstable share."""
    values = result.values[~np.isnan(result.values)]
    known = result.excess[~np.isnan(result.excess)]
    rows = [
        (name, f"{number(axis[0])} to {number(axis[-1])} {PARAMETERS[name].unit}, {axis.size}")
        for name, axis in zip(result.names, result.axes, strict=True)
    ]
    column = MAP_COLUMNS[result.value]
    span = f"{number(values.min())} to {number(values.max())} {column.unit}" if values.size else ""
    rows += [
        ("points", str(result.values.size)),
        (column.meaning, span.rstrip() or "none"),
        ("points without value", str(result.values.size - values.size)),
        ("unstable", f"{np.count_nonzero(known > 0.0) / result.values.size:.1%} of the points"),
    ]
    print_list("Stability map", rows)

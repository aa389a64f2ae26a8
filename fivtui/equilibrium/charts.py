"""Charts of the modes over the friction coefficient, and of the eigenvalues in the plane.

A `Label` has a text for the terminal and one for figures. Traces are `ordered` if y is a function
of x: those in the plane are not.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    Chart,
    Guide,
    Label,
    Sheet,
    Trace,
    axis_label,
    math_symbol,
    parameter_text,
)
from fivtui.model import PARAMETERS, Parameters

from .eigenvalues import Stability
from .scan import ModeScan

FloatArray = NDArray[np.float64]

_MODES_SIZE: Final = (7.2, 3.4)
_MODES: Final = ("mode 1", "mode 2")


def growth_chart(scan: ModeScan, p: Parameters, result: Stability) -> Chart:
    """Growth rates of the modes over μ, with μ and every μ_c marked."""
    label = Label("Re λ (1/s)", "Growth rate Re $λ$ (1/s)")
    # Growth rates are compared with 0, however far it is.
    zero = Guide(0.0, vertical=False, role="stability limit")
    guides = (zero, *_mu_guides(p, result))
    return _mode_chart(scan, label, scan.eigenvalues[:, :2].real, guides)


def frequency_chart(scan: ModeScan, p: Parameters, result: Stability) -> Chart:
    """Frequencies of the modes over μ, Hz, with μ and every μ_c marked."""
    label = Label("Im λ/(2π) (Hz)", "Frequency Im $λ$/(2π) (Hz)")
    hertz = scan.eigenvalues[:, :2].imag / (2.0 * np.pi)
    return _mode_chart(scan, label, hertz, _mu_guides(p, result))


def plane_chart(result: Stability, scan: ModeScan | None) -> Chart:
    """The eigenvalues in the complex plane, with their paths over μ."""
    values = result.eigenvalues
    name = Label("now", f"at $μ$ = {result.parameters.mu:.4g}")
    traces = [
        Trace(
            name,
            values.real,
            values.imag,
            look="points",
            ordered=False,
            mark="◆",
            role="present point",
        )
    ]
    if scan is not None:
        scanned, top = scan.eigenvalues.ravel(), f"{scan.mu[-1]:g}"
        name = Label(f"μ 0 to {top}", f"eigenvalues, $μ$ = 0 to {top}")
        path = Trace(name, scanned.real, scanned.imag, look="dots", ordered=False, role="path")
        traces.insert(0, path)
    guides = (Guide(0.0, "unstable →"), Guide(0.0, vertical=False))
    return Chart(
        Label("Re λ (1/s)", "Re $λ$ (1/s)"),
        Label("Im λ (rad/s)", "Im $λ$ (rad/s)"),
        tuple(traces),
        guides=guides,
        # With margins beyond the outermost eigenvalues.
        x_margins=True,
    )


def modes_sheet(result: Stability, scan: ModeScan) -> Sheet:
    """Frequency and growth rate over μ, and the eigenvalues in the complex plane."""
    p = result.parameters
    charts = (frequency_chart(scan, p, result), growth_chart(scan, p, result))
    # In figures the imaginary axis has no label: that would be an entry of the legend.
    plane = replace(plane_chart(result, scan), guides=(Guide(0.0),))
    return Sheet([[chart] for chart in (*charts, plane)], _MODES_SIZE, parameter_text(p))


def _mode_chart(
    scan: ModeScan, label: Label, parts: FloatArray, guides: tuple[Guide, ...]
) -> Chart:
    traces = tuple(
        Trace(name, scan.mu, part, role=name) for name, part in zip(_MODES, parts.T, strict=True)
    )
    return Chart(axis_label(PARAMETERS["mu"]), label, traces, guides=guides)


def _mu_guides(p: Parameters, result: Stability) -> tuple[Guide, ...]:
    # Lines at μ and at every critical μ. If several μ are critical, the label of each says what the
    # equilibrium becomes above it.
    symbol, has_several = math_symbol("μ_c"), len(result.critical_mu) > 1
    critical = []
    for change in result.critical_mu:
        consequence = f", above it {change.becomes}" if has_several else ""
        figure_text = f"{symbol} = {change.mu:.4g}{consequence}"
        label = Label(f"μ_c {change.mu:.4g}", figure_text)
        critical.append(Guide(change.mu, label, role="critical"))
    present = Guide(p.mu, Label(f"μ {p.mu:.4g}", f"$μ$ = {p.mu:.4g}"), role="present")
    return (*critical, present)

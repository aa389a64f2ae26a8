"""Charts of the stability tab: modes over μ, eigenvalues in the plane. Imports no Textual."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import Chart, Guide, Trace
from fivtui.equilibrium import ModeScan, Stability
from fivtui.model import Parameters

FloatArray = NDArray[np.float64]

_MODES: Final = ("mode 1", "mode 2")


def _guides(p: Parameters, found: Stability) -> tuple[Guide, ...]:
    critical = tuple(Guide(c.mu, f"μ_c {c.mu:.4g}") for c in found.critical_mu)
    return (*critical, Guide(p.mu, f"μ {p.mu:.4g}"))


def _over_mu(scan: ModeScan, label: str, parts: FloatArray, guides: tuple[Guide, ...]) -> Chart:
    traces = tuple(Trace(name, scan.mu, parts[:, place]) for place, name in enumerate(_MODES))
    return Chart("μ", label, traces, guides=guides)


def growth_chart(scan: ModeScan, p: Parameters, found: Stability) -> Chart:
    """Growth rates of the modes over μ, with μ and every μ_c marked."""
    guides = (Guide(0.0, vertical=False), *_guides(p, found))
    return _over_mu(scan, "Re λ (1/s)", scan.eigenvalues[:, :2].real, guides)


def frequency_chart(scan: ModeScan, p: Parameters, found: Stability) -> Chart:
    """Frequencies of the modes over μ, Hz, with μ and every μ_c marked."""
    parts = scan.eigenvalues[:, :2].imag / (2.0 * np.pi)
    return _over_mu(scan, "Im λ/(2π) (Hz)", parts, _guides(p, found))


def plane_chart(found: Stability, scan: ModeScan | None) -> Chart:
    """The eigenvalues in the complex plane, with their paths over μ."""
    values = found.eigenvalues
    now = Trace("now", values.real, values.imag, look="points", ordered=False, mark="◆")
    paths: tuple[Trace, ...] = ()
    if scan is not None:
        along = scan.eigenvalues.ravel()
        paths = (
            Trace(f"μ 0 to {scan.mu[-1]:g}", along.real, along.imag, look="dots", ordered=False),
        )
    guides = (Guide(0.0, "unstable →"), Guide(0.0, vertical=False))
    return Chart("Re λ (1/s)", "Im λ (rad/s)", (*paths, now), guides=guides, tight=False)

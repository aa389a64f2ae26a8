"""Modes and stability as JSON data and as files, with units and provenance."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from fivtui.io import check_finite, write_table
from fivtui.model import PARAMETERS, Column

from .eigenvalues import Stability
from .modes import VibrationMode
from .scan import ModeScan, mode_scan, scan_top

_EIGENVALUES: Final = 4


def modes_over_mu(found: Stability) -> ModeScan:
    """Eigenvalues over evenly spaced μ, from 0 to beyond μ and every critical one.

    Raises `ComputationError` if there is no equilibrium at one of them.
    """
    return mode_scan(found.system, scan_top(found))


def save_modes(found: Stability, scan: ModeScan, path: Path, *, force: bool = False) -> None:
    """Write the eigenvalues over μ as ``.csv``, ``.npz`` or ``.parquet``.

    Columns are ``mu``, and ``sigma_1``, ``omega_1`` to ``sigma_4``, ``omega_4``: real and imaginary
    parts. Raises `InputError` if the format is unknown or its package missing, or the file cannot
    be written.
    """
    columns = [PARAMETERS["mu"].column]
    for number in range(1, _EIGENVALUES + 1):
        columns.append(Column(f"sigma_{number}", "1/s", f"real part of eigenvalue {number}"))
        columns.append(Column(f"omega_{number}", "rad/s", f"imaginary part of eigenvalue {number}"))
    header = {
        "parameters": found.parameters.as_dict(),
        "separation": found.separation,
        "critical_mu": [critical.mu for critical in found.critical_mu],
    }
    write_table(path, "table of modes", columns, scan.to_columns(), header, force=force)


def stability_to_dict(stability: Stability) -> dict[str, Any]:
    """A stability analysis as JSON data, in SI units.

    Keys are ``equilibrium``, ``eigenvalues`` as pairs of real and imaginary part, ``growth_rate``,
    ``stable``, ``critical_mu``, ``critical_speed``, ``linear_critical_mu``, ``modes``, ``margin``
    and ``coalescence``; frequencies in Hz, angular frequencies in rad/s. Raises `ComputationError`
    if a number is not finite.
    """
    point = stability.equilibrium
    data = {
        "equilibrium": {"x": point.x, "y": point.y, "P": point.P},
        "eigenvalues": [[value.real, value.imag] for value in stability.eigenvalues.tolist()],
        "growth_rate": stability.growth_rate,
        "stable": stability.stable,
        "critical_mu": [asdict(critical) for critical in stability.critical_mu],
        "critical_speed": [asdict(critical) for critical in stability.critical_speed],
        "linear_critical_mu": stability.linear_critical_mu,
        "modes": [_mode_to_dict(mode) for mode in stability.modes],
        "margin": asdict(stability.margin),
        "coalescence": asdict(stability.coalescence),
    }
    check_finite(data, "", "use parameters of less extreme size")
    return data


def _mode_to_dict(mode: VibrationMode) -> dict[str, Any]:
    x, y = mode.shape
    return {
        "frequency": mode.frequency,
        "angular_frequency": mode.angular_frequency,
        "growth_rate": mode.growth_rate,
        "damping_ratio": mode.damping_ratio,
        "shape": {"x": [x.real, x.imag], "y": [y.real, y.imag]},
    }

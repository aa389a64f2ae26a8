"""The modes over the friction coefficient in files, with units and provenance."""

from pathlib import Path
from typing import BinaryIO, Final

from fivtui.io.files import write_atomically
from fivtui.io.formats import columns_format
from fivtui.model.columns import Column
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.version import __version__

from .eigenvalues import Stability
from .scan import ModeScan, mode_scan, scan_top

_EIGENVALUES: Final = 4


def modes_over_mu(p: Parameters, found: Stability, *, separation: bool = True) -> ModeScan:
    """The eigenvalues from μ = 0 to beyond μ and every critical one.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    found : Stability
        Its stability.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    ModeScan
        At evenly spaced friction coefficients.

    Raises
    ------
    ComputationError
        If there is no equilibrium somewhere on the way.
    """
    return mode_scan(p, scan_top(p, found), separation=separation)


def save_modes(
    p: Parameters,
    found: Stability,
    scan: ModeScan,
    path: Path,
    *,
    separation: bool = True,
    force: bool = False,
) -> None:
    """Write the eigenvalues over the friction coefficient.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    found : Stability
        Its stability.
    scan : ModeScan
        Its eigenvalues over μ.
    path : Path
        The file; its suffix ``.csv``, ``.npz`` or ``.parquet`` says the format. Columns are ``mu``,
        and ``sigma_1``, ``omega_1`` to ``sigma_4``, ``omega_4``: real and imaginary parts.
    separation : bool
        Whether separation was considered.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the format is unknown or needs a package that is not installed, or the file cannot be
        written.
    """
    form = columns_format(path, "table of modes")
    mu = PARAMETERS["mu"]
    columns, values = [Column("mu", mu.unit, mu.meaning)], {"mu": scan.mu}
    for place in range(_EIGENVALUES):
        number, eigenvalue = place + 1, scan.eigenvalues[:, place]
        columns.append(Column(f"sigma_{number}", "1/s", f"real part of eigenvalue {number}"))
        columns.append(Column(f"omega_{number}", "rad/s", f"imaginary part of eigenvalue {number}"))
        values |= {f"sigma_{number}": eigenvalue.real, f"omega_{number}": eigenvalue.imag}
    provenance = {
        "fivtui": __version__,
        "parameters": p.as_dict(),
        "separation": separation,
        "critical_mu": [critical.mu for critical in found.critical_mu],
    }

    def write(file: BinaryIO) -> None:
        form.write(file, columns, values, provenance)

    write_atomically(path, write, force=force)

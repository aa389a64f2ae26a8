"""Eigenvalues at the equilibrium over the friction coefficient."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS, Cancelled, Column, System, equilibrium, jacobian
from fivtui.results import Result, Table, Tabular

from .eigenvalues import Stability

FloatArray = NDArray[np.float64]

_POINT_COUNT: Final = 241
# Number of points between calls of `should_continue`.
_BLOCK: Final = 24
_MIN_TOP: Final = 1.0
_TOP_FACTOR: Final = 1.5
# Frequencies closer than this, relative to the fastest, have merged.
_MERGED_DISTANCE: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ModeScan(Result, Tabular):
    """Eigenvalues at the equilibrium over μ; other parameters stay the same.

    Attributes
    ----------
    mu : ndarray, shape (n,)
        Friction coefficients, ascending from 0.
    eigenvalues : ndarray of complex, shape (n, 4)
        λ in 1/s, by falling imaginary part; equal ones by falling real part.
    """

    mu: FloatArray
    eigenvalues: NDArray[np.complex128]

    def _summary(self) -> list[tuple[str, str]]:
        growth = self.eigenvalues.real.max(axis=1)
        return [
            ("mu", f"{self.mu[0]:g} to {self.mu[-1]:g}, {self.mu.size} values"),
            ("growth rate", f"{growth.min():.6g} to {growth.max():.6g} 1/s"),
        ]

    def _table(self) -> Table:
        table: Table = {PARAMETERS["mu"].column: self.mu}
        for number, values in enumerate(self.eigenvalues.T, start=1):
            real = Column(f"sigma_{number}", "1/s", f"real part of eigenvalue {number}")
            imaginary = Column(f"omega_{number}", "rad/s", f"imaginary part of eigenvalue {number}")
            table |= {real: values.real.copy(), imaginary: values.imag.copy()}
        return table


def scan_top(result: Stability) -> float:
    """Upper end of a scan: a round number beyond μ and every critical μ.

    A round number stays the same while a value is edited.
    """
    p = result.parameters
    highest = PARAMETERS["mu"].upper if p.mu_s is None else p.mu_s
    lowest_top = _TOP_FACTOR * max(
        _MIN_TOP / _TOP_FACTOR, p.mu, *(c.mu for c in result.critical_mu), 0.0
    )
    decade = 10.0 ** np.floor(np.log10(lowest_top))
    top = next(f * decade for f in (1.0, 1.5, 2.0, 3.0, 5.0, 10.0) if f * decade >= lowest_top)
    return float(min(top, highest))


def mode_scan(
    system: System,
    top: float,
    *,
    should_continue: Callable[[], bool] = lambda: True,
) -> ModeScan:
    """Eigenvalues over evenly spaced μ from 0 to `top`.

    Raises `ComputationError` if there is no equilibrium, and `Cancelled` if `should_continue`,
    called repeatedly, returns False.
    """
    mu = np.linspace(0.0, top, _POINT_COUNT)
    matrices = np.empty((_POINT_COUNT, 4, 4))
    for index, value in enumerate(mu.tolist()):
        if index % _BLOCK == 0 and not should_continue():
            raise Cancelled
        changed = system.with_values({"mu": value})
        point = equilibrium(changed)
        matrices[index] = jacobian(changed.parameters, point.y, point.mode)
    values = np.linalg.eigvals(matrices).astype(np.complex128)
    # Frequencies that differ by rounding have merged; their real parts give the order.
    size = _MERGED_DISTANCE * np.abs(values).max()
    order = np.lexsort((-values.real, -np.rint(values.imag / size)), axis=-1)
    return ModeScan(mu, np.take_along_axis(values, order, axis=-1))

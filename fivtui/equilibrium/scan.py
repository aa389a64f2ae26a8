"""Eigenvalues at the equilibrium over the friction coefficient."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    PARAMETERS,
    Column,
    ComputationError,
    System,
    equilibrium,
    jacobian,
)
from fivtui.results import Result, Table, Tabular

from .eigenvalues import Stability, in_order

FloatArray = NDArray[np.float64]

_POINT_COUNT: Final = 241
# Least upper end of a scan, and the factor by which it exceeds μ and every critical μ.
_MIN_TOP: Final = 1.0
_TOP_FACTOR: Final = 1.5
# The upper end is one of these times a power of ten.
_ROUND_NUMBERS: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0)


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


def mu_scan_end(result: Stability) -> float:
    """Upper end of a scan over μ: a round number beyond μ and every critical μ.

    A round number keeps the axis unchanged while a parameter is edited in small steps.
    """
    p = result.parameters
    mu_max = PARAMETERS["mu"].upper if p.mu_s is None else p.mu_s
    marked_values = (p.mu, *(critical.mu for critical in result.critical_mu))
    min_top = max(_MIN_TOP, _TOP_FACTOR * max(marked_values))
    decade = 10.0 ** np.floor(np.log10(min_top))
    round_numbers = (factor * decade for factor in _ROUND_NUMBERS)
    return float(min(next(number for number in round_numbers if number >= min_top), mu_max))


def mode_scan(system: System, top: float) -> ModeScan:
    """Eigenvalues over evenly spaced μ from 0 to `top`, or to the last with an equilibrium.

    Raises `ComputationError` if there is none.
    """
    mu = np.linspace(0.0, top, _POINT_COUNT)
    matrices = np.empty((_POINT_COUNT, 4, 4))
    for index, value in enumerate(mu.tolist()):
        changed = system.with_values({"mu": value})
        try:
            point = equilibrium(changed)
        except ComputationError:
            if index == 0:
                raise
            mu, matrices = mu[:index], matrices[:index]
            break
        matrices[index] = jacobian(changed.parameters, point.y, point.mode)
    values = np.linalg.eigvals(matrices).astype(np.complex128)
    return ModeScan(mu, in_order(values))

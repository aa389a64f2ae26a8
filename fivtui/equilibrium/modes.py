"""Modes of vibration about the equilibrium: frequencies, damping ratios and shapes.

They solve the linearised equations of motion, Eq. 8 of the paper. The `mode` of an equilibrium, by
contrast, is the state of the contact.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    IN_CONTACT,
    Equilibrium,
    Parameters,
    coupling_stiffness,
    horizontal_stiffness,
    sliding_coefficients,
    tangent_stiffness,
)
from fivtui.results import to_data


@dataclass(frozen=True, slots=True)
class VibrationMode:
    """A mode: a pair of conjugate eigenvalues or a real one, and its shape.

    Attributes
    ----------
    eigenvalue : complex
        λ in 1/s, with Im λ ≥ 0.
    shape : tuple of complex
        Amplitudes (x, y) of the motion e^{λt}, the larger one scaled to 1; the difference of their
        phases is that between horizontal and vertical motion.
    """

    eigenvalue: complex
    shape: tuple[complex, complex]

    def to_dict(self) -> dict[str, Any]:
        """The mode as data for JSON; amplitudes as pairs of real and imaginary part."""
        names = ("frequency", "angular_frequency", "growth_rate", "damping_ratio")
        x, y = map(complex, self.shape)
        data: dict[str, Any] = {name: getattr(self, name) for name in names}
        data["shape"] = to_data({"x": x, "y": y})
        return data

    @property
    def growth_rate(self) -> float:
        """Re λ, 1/s."""
        return self.eigenvalue.real

    @property
    def angular_frequency(self) -> float:
        """Im λ, rad/s; zero without oscillation."""
        return self.eigenvalue.imag

    @property
    def frequency(self) -> float:
        """Im λ/(2π), Hz."""
        return self.eigenvalue.imag / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """−Re λ/|λ|: 1 without oscillation, negative if the vibration grows."""
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size > 0.0 else 0.0


def vibration_modes(
    p: Parameters, point: Equilibrium, eigenvalues: NDArray[np.complex128]
) -> tuple[VibrationMode, ...]:
    """The modes of the four eigenvalues at an equilibrium, by falling frequency.

    A pair of conjugate eigenvalues is one mode; every real eigenvalue is a mode.
    """
    return tuple(
        VibrationMode(value, _shape(p, point, value))
        for value in eigenvalues.tolist()
        if value.imag >= 0.0
    )


def _shape(p: Parameters, point: Equilibrium, value: complex) -> tuple[complex, complex]:
    # The null vector of the dynamic stiffness, from its larger row: the smaller one may vanish.
    a, h = horizontal_stiffness(p), coupling_stiffness(p)
    kt = tangent_stiffness(p, point.y) if point.mode in IN_CONTACT else 0.0
    # Friction that depends on the sliding speed adds its slope times the contact force to c1.
    mu, c1 = sliding_coefficients(p, point.y, point.mode)
    horizontal = (p.m * value + c1) * value + a
    vertical = (p.m * value + p.c2) * value + kt + h
    # Null vectors of the rows (horizontal, μ k_t − h) and (−h, vertical), each as large as its row.
    null_vectors = ((h - mu * kt, horizontal), (vertical, complex(h)))
    x, y = max(null_vectors, key=lambda vector: abs(vector[0]) + abs(vector[1]))
    largest = x if abs(x) >= abs(y) else y
    # If both rows vanish, every direction is a mode.
    return (x / largest, y / largest) if largest != 0.0 else (1.0 + 0.0j, 0.0j)

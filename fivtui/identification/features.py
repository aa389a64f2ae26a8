"""Features of a system as targets of a fit, with their derivatives by parameters."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mu, critical_mu_derivatives
from fivtui.model import (
    DERIVATIVE_STEP,
    IN_CONTACT,
    ComputationError,
    InputError,
    System,
    check_always_sliding,
    check_has_verdict,
    check_known,
    equilibrium,
    jacobian,
    parse_number,
    rest_coefficients,
)
from fivtui.orbits import Explorer
from fivtui.taylor import Seed
from fivtui.transient import EXTREMES, START_SEEDS, Request, compute_variation

Floats = NDArray[np.float64]
# The value of a feature, and its derivatives by names.
Feature = tuple[float, Floats]

_TARGET: Final = re.compile(r"\s*([a-z-]+)\s*=\s*(.+?)\s*(?:±|\+-)\s*(.+)")
_TARGET_FORM: Final = "NAME=VALUE±SD, e.g. frequency=2000±10"
_TOL: Final = 1e-12
_Y_MIN, _Y_MAX = EXTREMES.index("y_min"), EXTREMES.index("y_max")


class Target(NamedTuple):
    """A measured feature: its name, its value and its standard deviation, SI units."""

    name: str
    value: float
    sd: float


def parse_target(text: str) -> Target:
    """The target in a text such as ``frequency=2000±10``; +- is read as ±."""
    match = _TARGET.fullmatch(text)
    if match is None:
        raise InputError(f"--target {text}: must be {_TARGET_FORM}")
    name, value, sd = match.groups()
    check_known("target", name, FEATURES)
    target = Target(
        name, *(parse_number(f"--target {text}", part, _TARGET_FORM) for part in (value, sd))
    )
    if target.sd <= 0.0:
        raise InputError(f"--target {text}: SD must be above 0")
    return target


def check_targets(targets: Sequence[Target], system: System) -> None:
    """Raise `InputError` where features are not defined: on belts of finite speed."""
    if targets:
        check_always_sliding(system.parameters, "--target")


def compute_feature(system: System, name: str, names: Sequence[str]) -> Feature:
    """A feature and its derivatives by parameters; `ComputationError` if the system has none."""
    return FEATURES[name](system, names)


def _critical_mu(system: System, names: Sequence[str]) -> Feature:
    changes = critical_mu_derivatives(system, names)
    if changes is None:
        raise ComputationError("there is no critical μ", "leave out this target")
    # μ itself has no effect on the critical μ.
    return critical_mu(system)[0].mu, np.array([changes.get(name, 0.0) for name in names])


def _eigenvalue(system: System, names: Sequence[str]) -> tuple[complex, NDArray[np.complex128]]:
    # The rightmost eigenvalue λ with Im λ ≥ 0, and its derivatives wᴴ J′ v/(wᴴ v), with the right
    # and left eigenvectors v and w of the Jacobian J.
    check_has_verdict(system)
    p, point = system.parameters, equilibrium(system)
    if point.mode not in IN_CONTACT:
        raise ComputationError("the slider is lifted off the belt", "take F above 0")
    values, vectors = np.linalg.eig(np.array(jacobian(p, point.y, point.mode)))
    oscillating = np.flatnonzero(values.imag >= 0.0)
    index = int(oscillating[values[oscillating].real.argmax()])
    left_vector = np.linalg.inv(vectors)[index]

    def residual(parameters: Any, y: complex) -> float:
        # Imaginary part of the equation of the equilibrium.
        alpha, beta, load = rest_coefficients(parameters, parameters.mu)
        return float((alpha * y * y * y + beta * y + load).imag)

    slope = residual(p, complex(point.y, DERIVATIVE_STEP))
    changes = []
    for name in names:
        perturbed: Any = p.perturbed({name: 1.0})
        height_step = -residual(perturbed, point.y) / slope * DERIVATIVE_STEP
        height: Any = complex(point.y, height_step)
        matrix = np.array(jacobian(perturbed, height, point.mode)).imag / DERIVATIVE_STEP
        changes.append(left_vector @ matrix @ vectors[:, index])
    return complex(values[index]), np.array(changes)


def _growth_rate(system: System, names: Sequence[str]) -> Feature:
    value, changes = _eigenvalue(system, names)
    return value.real, changes.real


def _frequency(system: System, names: Sequence[str]) -> Feature:
    value, changes = _eigenvalue(system, names)
    return value.imag / math.tau, changes.imag / math.tau


def _cycle(system: System, names: Sequence[str]) -> tuple[Feature, Feature]:
    # Period and half peak-to-peak of y of the limit cycle that is reached from the static start.
    attractor = Explorer(system).reach("static")
    if (orbit := attractor.orbit) is None:
        raise ComputationError(
            f"there is no limit cycle from the static start: {attractor.description}",
            "begin with a greater friction coefficient",
        )
    seeds = [*START_SEEDS, *(Seed((0.0, 0.0, 0.0, 0.0), {name: 1.0}) for name in names)]
    request = Request(system, orbit.period, _TOL, orbit.start)
    variation = compute_variation(request, seeds)
    # Start z and period T change so that z(T) − z = 0 and the start stays on its section.
    matrix = np.zeros((5, 5))
    matrix[:4, :4] = variation.derivatives[:, :4] - np.eye(4)
    matrix[:4, 4] = variation.final_rate
    matrix[4, orbit.section.value] = 1.0
    right_side = np.vstack([-variation.derivatives[:, 4:], np.zeros(len(names))])
    changes = np.linalg.solve(matrix, right_side)
    extremes = variation.extreme_derivatives
    extreme_changes = extremes[:, :4] @ changes[:4] + extremes[:, 4:]
    half_range_changes = 0.5 * (extreme_changes[_Y_MAX] - extreme_changes[_Y_MIN])
    return (orbit.period, changes[4]), (orbit.half_range, half_range_changes)


def _half_range(system: System, names: Sequence[str]) -> Feature:
    return _cycle(system, names)[1]


def _cycle_frequency(system: System, names: Sequence[str]) -> Feature:
    period, changes = _cycle(system, names)[0]
    return 1.0 / period, -changes / period**2


FEATURES: Final[Mapping[str, Callable[[System, Sequence[str]], Feature]]] = {
    "frequency": _frequency,
    "growth-rate": _growth_rate,
    "critical-mu": _critical_mu,
    "half-range": _half_range,
    "cycle-frequency": _cycle_frequency,
}

"""Sensitivities of a transient: derivatives of its results by parameters."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Self

import numpy as np

from fivtui.model import (
    DERIVATIVE_STEP,
    Progress,
    derivative,
    spring_force,
    static_start_change,
    time_scale,
)
from fivtui.taylor import Seed
from fivtui.transient.request import Request
from fivtui.transient.result import ContactForce, Peak, Steady, Transient

from .variation import EXTREMES, START_SEEDS, Variation, compute_variation

_ZERO_STATE: Final = (0.0, 0.0, 0.0, 0.0)


class FinalChange(NamedTuple):
    """Derivatives of the state at the end."""

    x: float
    vx: float
    y: float
    vy: float


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Derivatives of the results of a transient by a parameter, in units of result per parameter.

    An extreme has the derivative of the motion at the first time at which the motion takes it. If
    the motion takes it again, the derivative is one-sided. A slider at rest takes its extremes at
    the start. At a kink, such as an absolute value at zero or a contact force at touch, the
    derivative is that towards greater values. If the slider separates, the least contact force and
    its derivative are zero.

    Attributes
    ----------
    final : FinalChange
        Derivatives of the final state.
    peak, steady, contact_force
        Derivatives of the results with these names in `Transient`.
    """

    final: FinalChange
    peak: Peak
    steady: Steady
    contact_force: ContactForce


# The parts of a `Sensitivity` with their types.
_PARTS: Final[dict[str, Callable[..., Any]]] = {
    "final": FinalChange,
    "peak": Peak,
    "steady": Steady,
    "contact_force": ContactForce,
}


@dataclass(frozen=True, slots=True)
class Sensitivities(Mapping[str, Sensitivity]):
    """A mapping from the names of parameters to their sensitivities.

    Attributes
    ----------
    by : dict
        The sensitivities.
    growth : float
        Largest factor by which a small deviation of the start grows until the end; velocities are
        scaled by √(m/(k1 + k2 + k3)). Derivatives are valid for changes much smaller than 1/growth,
        and have a relative error of about `tol` times growth.
    """

    by: dict[str, Sensitivity]
    growth: float

    def __getitem__(self, name: str) -> Sensitivity:
        return self.by[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by)

    def __len__(self) -> int:
        return len(self.by)

    def to_dict(self) -> dict[str, Any]:
        """Data for JSON: ``growth``, and in ``by`` the derivatives for each parameter."""
        by = {
            name: {part: getattr(sensitivity, part)._asdict() for part in _PARTS}
            for name, sensitivity in self.by.items()
        }
        return {"growth": self.growth, "by": by}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Read the data that `to_dict` returns."""
        by = {
            name: Sensitivity(**{part: record(**row[part]) for part, record in _PARTS.items()})
            for name, row in data["by"].items()
        }
        return cls(by, float(data["growth"]))

    def digits(self, tol: float) -> int:
        """Number of correct digits of the derivatives of the final state at a tolerance."""
        return max(math.floor(-math.log10(tol * max(self.growth, 1.0))), 0)


def compute_sensitivities(request: Request, run: Transient, work: Progress) -> Sensitivities:
    """The requested sensitivities of a transient; see `simulate`."""
    p, names = request.parameters, request.sensitivities
    is_static = isinstance(request.start, str)
    # Directions of change: the parameter by 1, and the static start with it.
    seeds = [
        Seed(
            static_start_change(request.system, name) if is_static else _ZERO_STATE,
            {name: 1.0},
        )
        for name in names
    ]
    variation = compute_variation(request, [*START_SEEDS, *seeds], work)
    # Columns of the variation: first the derivatives by the start, then those by the parameters.
    start_count = len(START_SEEDS)
    weights = np.array([1.0, time_scale(p), 1.0, time_scale(p)])
    scaled_derivatives = variation.derivatives[:, :start_count] * weights[:, None] / weights
    by = {
        name: _sensitivity(run, name, variation, column)
        for column, name in enumerate(names, start=start_count)
    }
    return Sensitivities(by, float(np.linalg.norm(scaled_derivatives, 2)))


def _sensitivity(transient: Transient, name: str, variation: Variation, column: int) -> Sensitivity:
    # The derivatives by a parameter, from the column of its seed.
    p, separation = transient.parameters, transient.separation
    values: dict[str, float] = dict(zip(EXTREMES, variation.extremes.tolist(), strict=True))
    slopes: dict[str, float] = dict(
        zip(EXTREMES, variation.extreme_derivatives[:, column].tolist(), strict=True)
    )
    x, vx, y, vy = variation.derivatives[:, column].tolist()
    # For derivatives by a complex step: this parameter has the imaginary part `DERIVATIVE_STEP`.
    perturbed = p.perturbed({name: 1.0})

    def peak_derivative(minimum: str, maximum: str) -> float:
        # Derivative of the greatest absolute value between a minimum and a maximum.
        if values[maximum] == -values[minimum]:
            return max(slopes[maximum], -slopes[minimum])
        return slopes[maximum] if values[maximum] > -values[minimum] else -slopes[minimum]

    def force_derivative(y_name: str) -> float:
        # Derivative of the contact force at an extreme of y, by a complex step.
        y = values[y_name]
        if separation and (y > 0.0 or (y == 0.0 and slopes[y_name] >= 0.0)):
            return 0.0
        return derivative(spring_force(perturbed, complex(y, slopes[y_name] * DERIVATIVE_STEP)))

    return Sensitivity(
        FinalChange(x, vx, y, vy),
        Peak(
            peak_derivative("y_min", "y_max"),
            slopes["y_max"],
            slopes["y_min"],
            peak_derivative("x_min", "x_max"),
            slopes["vx_max"],
        ),
        Steady(0.5 * (slopes["second_half_max"] - slopes["second_half_min"])),
        ContactForce(force_derivative("y_max"), force_derivative("y_min")),
    )

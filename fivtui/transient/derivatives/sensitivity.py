"""Sensitivities of a transient: derivatives of its results by parameters."""

import math
from collections.abc import Iterator, Mapping
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

from .variation import EXTREMES, START_SEEDS, Variation, vary

_AT_REST: Final = (0.0, 0.0, 0.0, 0.0)


class FinalChange(NamedTuple):
    """Derivatives of the state at the end."""

    x: float
    vx: float
    y: float
    vy: float


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Derivatives of the results of a transient by a parameter, each in its unit per that of it.

    An extreme has the derivative of the motion at the time where it is taken, the first if it is
    taken more than once: then that holds to one side alone, and of a slider that rests, which is at
    its extremes all the time, it is the derivative of the start. What has a kink, as a size at zero
    or the contact force where the slider just touches, has the derivative towards greater values.
    The least contact force of a slider that comes off the belt is zero and stays so.

    Attributes
    ----------
    final : FinalChange
        Of the state at the end.
    peak, steady, contact_force
        Of the numbers with these names in `Transient`.
    """

    final: FinalChange
    peak: Peak
    steady: Steady
    contact_force: ContactForce


@dataclass(frozen=True, slots=True)
class Sensitivities(Mapping[str, Sensitivity]):
    """Sensitivities by the name of the parameter.

    Attributes
    ----------
    by : dict
        The sensitivities.
    growth : float
        By how much small deviations of the start grow at most until the end, displacements beside
        velocities times √(m/stiffness). Derivatives hold for changes that are small against its
        inverse, and have lost the digits that `tol` times it takes.
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
        """All as data for JSON: ``growth``, and ``by`` parameter the derivatives by name."""
        parts = ("final", "peak", "steady", "contact_force")
        by = {
            name: {part: getattr(sensitivity, part)._asdict() for part in parts}
            for name, sensitivity in self.by.items()
        }
        return {"growth": self.growth, "by": by}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Read the data that `to_dict` returns."""
        by = {
            name: Sensitivity(
                FinalChange(**row["final"]),
                Peak(**row["peak"]),
                Steady(**row["steady"]),
                ContactForce(**row["contact_force"]),
            )
            for name, row in data["by"].items()
        }
        return cls(by, float(data["growth"]))

    def digits(self, tol: float) -> int:
        """How many digits of the derivatives of the final state to believe at a tolerance."""
        return max(math.floor(-math.log10(tol * max(self.growth, 1.0))), 0)


def sensitivities_of(request: Request, transient: Transient, work: Progress) -> Sensitivities:
    """The requested sensitivities of a transient; see `simulate`."""
    p, names = request.parameters, request.sensitivities
    static = isinstance(request.start, str)
    seeds = [
        Seed(
            static_start_change(request.system, name) if static else _AT_REST,
            {name: 1.0},
        )
        for name in names
    ]
    variation = vary(request, [*START_SEEDS, *seeds], work)
    count = len(START_SEEDS)
    weights = np.array([1.0, time_scale(p), 1.0, time_scale(p)])
    flow = variation.derivatives[:, :count] * weights[:, None] / weights
    by = {
        name: _sensitivity(transient, name, variation, column)
        for column, name in enumerate(names, start=count)
    }
    return Sensitivities(by, float(np.linalg.norm(flow, 2)))


def _sensitivity(transient: Transient, name: str, variation: Variation, column: int) -> Sensitivity:
    p, considered = transient.parameters, transient.separation
    value: dict[str, float] = dict(zip(EXTREMES, variation.extremes.tolist(), strict=True))
    change: dict[str, float] = dict(
        zip(EXTREMES, variation.extreme_derivatives[:, column].tolist(), strict=True)
    )
    x, vx, y, vy = variation.derivatives[:, column].tolist()
    moved = p.perturbed({name: 1.0})

    def size(low: str, high: str) -> float:
        if value[high] == -value[low]:
            return max(change[high], -change[low])
        return change[high] if value[high] > -value[low] else -change[low]

    def force(height: str) -> float:
        y = value[height]
        if considered and (y > 0.0 or (y == 0.0 and change[height] >= 0.0)):
            return 0.0
        return derivative(spring_force(moved, complex(y, change[height] * DERIVATIVE_STEP)))

    return Sensitivity(
        FinalChange(x, vx, y, vy),
        Peak(
            size("y_min", "y_max"),
            change["y_max"],
            change["y_min"],
            size("x_min", "x_max"),
            change["vx_max"],
        ),
        Steady(0.5 * (change["y_high"] - change["y_low"])),
        ContactForce(force("y_max"), force("y_min")),
    )

"""Flows whose periodic orbits are followed: that of the slider-belt model, or any other."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, InputError, Parameters
from fivtui.taylor import Seed
from fivtui.transient import START_SEEDS, Request, vary

FloatArray = NDArray[np.float64]

FLOW_TOL: Final = 1e-13
MOST_STEPS: Final = 20_000


@dataclass(frozen=True, slots=True)
class Return:
    """Where a motion is after a time, with derivatives.

    Attributes
    ----------
    final, rate : ndarray, shape (n,)
        The state, and its derivative by time.
    derivatives : ndarray, shape (n, n + q)
        Its derivatives by the state at the start and the q parameters that vary.
    extremes : ndarray, shape (4,) or longer
        Least and greatest value of a first and a second displacement, then what else is kept.
    """

    final: FloatArray
    rate: FloatArray
    derivatives: FloatArray
    extremes: FloatArray


class Flow(Protocol):
    """A flow that depends on one or two parameters.

    Attributes
    ----------
    states : int
        Number n of state variables.
    """

    @property
    def states(self) -> int:
        """Number of state variables."""
        ...

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> Return | None:
        """The motion from a state, with values of the parameters; None if there is none."""
        ...


class SliderBeltFlow:
    """The flow of the slider-belt model.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    names : sequence of str
        The parameters that vary, one or two.
    separation : bool
        Whether separation is considered.
    """

    states: Final = 4

    def __init__(self, p: Parameters, names: Sequence[str], *, separation: bool = True) -> None:
        self.p, self.names, self.separation = p, tuple(names), separation
        self._seeds = [*START_SEEDS, *(Seed((0.0,) * 4, {name: 1.0}) for name in names)]

    def parameters(self, values: Sequence[float]) -> Parameters:
        """The parameter set with values of what varies."""
        return self.p.with_values(dict(zip(self.names, values, strict=True)))

    def follow(self, state: FloatArray, time: float, values: FloatArray) -> Return | None:
        """As `Flow` says; None for values out of range and motions that run away."""
        try:
            request = Request(
                self.parameters(values.tolist()),
                t_end=float(time),
                tol=FLOW_TOL,
                separation=self.separation,
                start=state.tolist(),
                max_steps=MOST_STEPS,
            )
            there = vary(request, self._seeds)
        except (InputError, ComputationError):
            return None
        return Return(np.array(there.final), there.rate, there.derivatives, there.extremes)

"""Sample times of a run. Imports no Textual."""

import math
from fractions import Fraction
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, equilibrium, tangent_stiffness
from fivtui.scene import Scene

_PER_PERIOD: Final = 64
_FEWEST: Final = 1000
_MOST: Final = 250_000


def sample_interval(scene: Scene) -> Fraction:
    """A round interval, s, below 1/64 of the shortest linear period.

    1, 2 or 5 times a power of ten, limited to 1000 to 250 000 samples.
    """
    p = scene.parameters
    try:
        y = equilibrium(p, separation=scene.separation).y
    except ComputationError:
        y = 0.0
    # An upper bound of the natural frequencies: all springs on one mass.
    stiffness = p.k1 + p.k3 + tangent_stiffness(p, y)
    fitting = math.tau * math.sqrt(p.m / stiffness) / _PER_PERIOD
    interval = _rounded(min(fitting, scene.t_end / _FEWEST), up=False)
    shortest = scene.t_end / _MOST
    return interval if interval >= shortest else _rounded(shortest, up=True)


def sample_times(scene: Scene) -> NDArray[np.float64]:
    """0, the multiples of `sample_interval`, and the end time, s."""
    interval = sample_interval(scene)
    count = math.floor(scene.t_end / interval) + 1
    # Multiplying first gives exact decimal times.
    times = np.arange(count) * float(interval.numerator) / float(interval.denominator)
    return np.append(times[times < scene.t_end], scene.t_end)


def _rounded(value: float, *, up: bool) -> Fraction:
    decade = Fraction(10) ** math.floor(math.log10(value))
    candidates = [decade * r for r in (Fraction(1, 2), 1, 2, 5, 10, 20)]
    if up:
        return min(c for c in candidates if c >= value)
    return max(c for c in candidates if c <= value)

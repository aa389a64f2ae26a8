"""At which times a run is kept for plots and data files. Imports no Textual."""

import math
from fractions import Fraction
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model.errors import ComputationError
from fivtui.model.slider_belt import equilibrium, tangent_stiffness
from fivtui.scene.scene import Scene

_PER_PERIOD: Final = 64
_FEWEST: Final = 1000
_MOST: Final = 250_000


def sample_interval(scene: Scene) -> Fraction:
    """A round interval that resolves the fastest linear vibration.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    Fraction
        1, 2 or 5 times a power of ten, s, below 1/64 of the shortest natural period; but never
        so small that more than 250 000 samples are kept, nor so large that fewer than 1000 are.
    """
    p = scene.parameters
    try:
        y = equilibrium(p, separation=scene.separation).y
    except ComputationError:
        y = 0.0
    # No natural frequency exceeds that of all springs on one mass.
    stiffness = p.k1 + p.k3 + tangent_stiffness(p, y)
    fitting = math.tau * math.sqrt(p.m / stiffness) / _PER_PERIOD
    interval = _rounded(min(fitting, scene.t_end / _FEWEST), up=False)
    shortest = scene.t_end / _MOST
    return interval if interval >= shortest else _rounded(shortest, up=True)


def sample_times(scene: Scene) -> NDArray[np.float64]:
    """The times at which a run is kept.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    ndarray, shape (n,)
        0, every multiple of `sample_interval`, and the horizon, s.
    """
    interval = sample_interval(scene)
    count = math.floor(scene.t_end / interval) + 1
    # Multiplied before divided, the times are the decimal numbers that they should be.
    times = np.arange(count) * float(interval.numerator) / float(interval.denominator)
    return np.append(times[times < scene.t_end], scene.t_end)


def _rounded(value: float, *, up: bool) -> Fraction:
    decade = Fraction(10) ** math.floor(math.log10(value))
    candidates = [decade * r for r in (Fraction(1, 2), 1, 2, 5, 10, 20)]
    if up:
        return min(c for c in candidates if c >= value)
    return max(c for c in candidates if c <= value)

"""The rest position of the slider, and the scales of motion about it."""

import math
from typing import Final

import numpy as np

from fivtui.model import (
    Equilibrium,
    Parameters,
    State,
    System,
    coupling_stiffness,
    equilibrium,
    holding_force,
    horizontal_stiffness,
    load,
    spring_force,
    tangent_stiffness,
)

# Upper bound: Newton's method converges in a few iterations.
_MAX_ITERATIONS: Final = 60


def reference_point(system: System) -> Equilibrium:
    """The equilibrium; on a belt at rest, with a range of equilibria, that without friction."""
    if system.parameters.v_belt != 0.0:
        return equilibrium(system)
    return equilibrium(system.with_values({"v_belt": None}), mu=0.0)


def length_scale(system: System) -> float:
    """Characteristic length, m.

    The greater of the static deflection and the y at which the linear and the cubic contact force
    are equal; 1 if both are zero.
    """
    p, y = system.parameters, reference_point(system).y
    return max(abs(y), (p.k2 / p.k_nl) ** 0.5 if p.k_nl > 0.0 else 0.0) or 1.0


def slowest_period(p: Parameters) -> float:
    """Longest period, s, of the undamped modes without friction, in contact and off the belt."""
    # Without coupling (k3 = 0) only the contact has vertical stiffness.
    h, a = coupling_stiffness(p), horizontal_stiffness(p)
    lowest_stiffness = a
    for kt in (p.k2, 0.0):
        b = kt + h
        stiffness = (a * b - h * h) / (0.5 * (a + b) + np.hypot(0.5 * (a - b), h))
        if stiffness > 0.0:
            lowest_stiffness = min(lowest_stiffness, stiffness)
    return float(2.0 * np.pi * np.sqrt(p.m / lowest_stiffness))


def sticks_forever(p: Parameters, state: State) -> bool:
    """Whether a slider that sticks to a belt at rest never slips again.

    The energy bounds the vertical motion, as the stiffness is at least k2 + h. Friction must hold
    the slider at both bounds of the motion.
    """
    x, _, y, vy = state
    h = coupling_stiffness(p)
    y_rest, imbalance = y, 1.0
    for _ in range(_MAX_ITERATIONS):
        imbalance = spring_force(p, y_rest) - load(p) + h * (x - y_rest)
        y_rest += imbalance / (tangent_stiffness(p, y_rest) + h)
    stiffest = tangent_stiffness(p, max(abs(y), abs(y_rest))) + h
    energy = p.m * vy * vy + stiffest * (y - y_rest) ** 2
    amplitude = math.sqrt(energy / (p.k2 + h))
    low, high = y_rest - amplitude, y_rest + amplitude
    friction_limit = p.mu_static * spring_force(p, high)
    holding = max(abs(holding_force(p, x, low)), abs(holding_force(p, x, high)))
    return high < 0.0 and holding < friction_limit

"""The rest position of the slider, and the characteristic length and period of motion about it."""

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


def reference_equilibrium(system: System) -> Equilibrium:
    """The equilibrium; on a belt at rest, where it is not unique, the one without friction."""
    if system.parameters.v_belt != 0.0:
        return equilibrium(system)
    # `equilibrium` refuses a belt at rest; without friction the belt speed has no effect.
    return equilibrium(system.with_values({"v_belt": None}), mu=0.0)


def length_scale(system: System) -> float:
    """Characteristic length, m.

    The greater of the static deflection and the y at which the linear and the cubic contact force
    are equal; 1 if both are zero.
    """
    p, y = system.parameters, reference_equilibrium(system).y
    return max(abs(y), (p.k2 / p.k_nl) ** 0.5 if p.k_nl > 0.0 else 0.0) or 1.0


def slowest_period(p: Parameters) -> float:
    """Longest period, s, of the undamped modes without friction, in contact and off the belt."""
    coupling, horizontal = coupling_stiffness(p), horizontal_stiffness(p)
    lowest = horizontal
    for contact_stiffness in (p.k2, 0.0):
        vertical = contact_stiffness + coupling
        # The lower eigenvalue of the stiffness matrix is its determinant over the higher one.
        determinant = horizontal * vertical - coupling * coupling
        higher = 0.5 * (horizontal + vertical) + np.hypot(0.5 * (horizontal - vertical), coupling)
        lower = determinant / higher
        # Without coupling (k3 = 0) a slider off the belt has no vertical stiffness.
        if lower > 0.0:
            lowest = min(lowest, lower)
    return float(2.0 * np.pi * np.sqrt(p.m / lowest))


def sticks_forever(p: Parameters, state: State) -> bool:
    """Whether a slider that sticks to a belt at rest never slips again.

    At constant x the slider vibrates vertically about a height of rest. The greatest stiffness
    between this height and y bounds its energy, and the least, that of the contact at y = 0 and the
    coupling, bounds the amplitude at this energy. Friction must hold it at both bounds of y.
    """
    x, _, y, vy = state
    coupling = coupling_stiffness(p)
    # Newton's method finds where the upward forces of contact spring and coupling balance the load.
    y_rest = y
    for _ in range(_MAX_ITERATIONS):
        imbalance = spring_force(p, y_rest) - load(p) + coupling * (x - y_rest)
        y_rest += imbalance / (tangent_stiffness(p, y_rest) + coupling)
    greatest_stiffness = tangent_stiffness(p, max(abs(y), abs(y_rest))) + coupling
    doubled_energy = p.m * vy * vy + greatest_stiffness * (y - y_rest) ** 2
    amplitude = math.sqrt(doubled_energy / (p.k2 + coupling))
    low, high = y_rest - amplitude, y_rest + amplitude
    # The contact force falls with y: it is least at the highest point.
    friction_limit = p.mu_static * spring_force(p, high)
    # Friction is linear in y, so that the greatest one that sticking requires is at a bound.
    required_friction = max(abs(holding_force(p, x, low)), abs(holding_force(p, x, high)))
    return high < 0.0 and required_friction < friction_limit

"""Stability of sliding on a belt of finite speed, where friction depends on it.

About the equilibrium the slider has the friction coefficient μ_b = μ(v_belt), and its velocity
changes the friction force: c1 becomes c1 + P μ′(v_belt). At given y the condition of Hurwitz is a
cubic in μ, which may be met anew above a loss of stability.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import (
    PARAMETERS,
    Parameters,
    resting_height,
    spring_force,
    tangent_stiffness,
)

from .critical import Becomes, CriticalMu, critical_mu as critical_mu_of_constant

# Places at which a change of stability is looked for between two neighbours, and how far the
# friction law reaches, over v_s.
_PLACES: Final = 1000
_REACH: Final = 60.0


@dataclass(frozen=True, slots=True)
class CriticalSpeed:
    """A speed of the belt, m/s, at which stability changes, and what sliding becomes above it."""

    v_belt: float
    becomes: Becomes


def critical_mu_on_belt(p: Parameters, *, separation: bool = True) -> tuple[CriticalMu, ...]:
    """Every μ > 0, at most `mu_s`, at which the stability of sliding changes, ascending."""
    if p.mu_s is None or p.v_s is None or p.v_belt is None:
        return critical_mu_of_constant(p, separation=separation)
    if separation and p.F < 0.0:
        return ()
    speed, top = p.v_belt, min(p.mu_s, PARAMETERS["mu"].upper)
    found = _changes(lambda mu: _is_stable(p, mu, speed, separation=separation), 0.0, top)
    return tuple(CriticalMu(mu, becomes) for mu, becomes in found)


def critical_speeds(p: Parameters, *, separation: bool = True) -> tuple[CriticalSpeed, ...]:
    """Every belt speed above 0 at which the stability of sliding changes, ascending.

    Without coupling (k3 = 0) it is v_s ln(P (μ_s − μ)/(c1 v_s)).
    """
    fall, v_s = p.mu_static - p.mu, p.speed_law
    if v_s is None or p.v_belt is None or (separation and p.F < 0.0):
        return ()
    if p.k3 == 0.0:
        force = spring_force(p, resting_height(0.0, (p.k1, p.k2, p.k_nl), p.F, p.mu, separation))
        excess = force * fall / (p.c1 * v_s) if p.c1 > 0.0 else math.inf
        if not 1.0 < excess < math.inf:
            return ()
        return (CriticalSpeed(v_s * math.log(excess), "stable"),)
    found = _changes(
        lambda speed: _is_stable(p, p.mu, speed, separation=separation), 0.0, _REACH * v_s
    )
    return tuple(CriticalSpeed(speed, becomes) for speed, becomes in found)


def _is_stable(p: Parameters, mu: float, speed: float, *, separation: bool) -> bool:
    # By the criterion of Hurwitz.
    fall, v_s = p.mu_static - mu, p.v_s or math.inf
    share = math.exp(-speed / v_s)
    sliding = mu + fall * share
    m, h = p.m, 0.5 * p.k3
    y = resting_height(h, (p.k1, p.k2, p.k_nl), p.F, sliding, separation)
    kt = tangent_stiffness(p, y)
    a, b, c1, c2 = p.k1 + h, kt + h, p.c1 - spring_force(p, y) * fall * share / v_s, p.c2
    a3, a2, a1 = m * (c1 + c2), m * (a + b) + c1 * c2, c1 * b + c2 * a
    a0 = a * b - h * h + h * sliding * kt
    return min(a3, a2, a1, a0) > 0.0 and a1 * (a3 * a2 - m * m * a1) > a3 * a3 * a0


def _changes(
    stable: Callable[[float], bool], low: float, high: float
) -> list[tuple[float, Becomes]]:
    # Where a truth changes, to the last bit, and what it becomes.
    places = np.linspace(low, high, _PLACES + 1).tolist()
    found: list[tuple[float, Becomes]] = []
    before, was = places[0], stable(places[0])
    for place in places[1:]:
        now = stable(place)
        if now != was:
            left, right = before, place
            while left < (middle := 0.5 * (left + right)) < right:
                left, right = (left, middle) if stable(middle) == now else (middle, right)
            found.append((right, "stable" if now else "unstable"))
        before, was = place, now
    return found

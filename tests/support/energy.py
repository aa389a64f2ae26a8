"""Energy and power of the slider on the belt, written independently."""

from fivtui import Parameters
from fivtui.model import IN_CONTACT, Mode, State, friction_force


def mechanical_energy(p: Parameters, state: State, mode: Mode) -> float:
    """Energy in J, including that of the preload; zero at rest in the undeformed position."""
    x, vx, y, vy = state
    kinetic = 0.5 * p.m * (vx**2 + vy**2)
    # The coupling spring at 45° has the elongation (x − y)/√2.
    elastic = 0.5 * p.k1 * x**2 + 0.25 * p.k3 * (x - y) ** 2
    contact = 0.5 * p.k2 * y**2 + 0.25 * p.k_nl * y**4 if mode in IN_CONTACT else 0.0
    return kinetic + elastic + contact + p.F * y


def power(p: Parameters, state: State, mode: Mode) -> tuple[float, float]:
    """Power supplied by friction and power lost by damping, W; their difference is d(energy)/dt."""
    _, vx, _, vy = state
    return friction_force(p, state, mode) * vx, p.c1 * vx**2 + p.c2 * vy**2

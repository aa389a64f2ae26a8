"""Stability of sliding on a belt of finite speed, where friction depends on it.

About the equilibrium the slider has the friction coefficient μ_b = μ + (μ_s − μ) e, e = e^(−v/v_s),
and its velocity changes the friction force: c1 becomes C = c1 − P (μ_s − μ) e/v_s. At given y the
condition of Hurwitz is a cubic in μ, and y depends on μ by the coupling. But y gives μ_b,

    h μ_b P = a F + h k1 y − a P,

so that both the condition and C are polynomials in y once they are multiplied by P and h v_s. Their
roots are isolated in rational numbers: every change of stability is found, for these parameters as
they are.
"""

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from fivtui.model import (
    PARAMETERS,
    Parameters,
    coupling_stiffness,
    horizontal_stiffness,
    load,
    parameter_spec,
    resting_height,
    spring_force,
)

from .critical import Becomes, CriticalMu, critical_mu as critical_mu_of_constant
from .exact import Polynomial, integers, product, real_roots, total, value_at

# How far heights in numbers of double precision may be off, at first.
_MARGIN: Final = Fraction(1, 2**40)
# A share of the static friction below this power of 1/2 is none.
_LEAST_SHARE: Final = 1100
_LESS: Final = (Fraction(-1),)
_HALF: Final = 0.5


@dataclass(frozen=True, slots=True)
class CriticalSpeed:
    """A speed of the belt, m/s, at which stability changes, and what sliding becomes above it."""

    v_belt: float
    becomes: Becomes


def critical_mu_on_belt(p: Parameters, *, separation: bool = True) -> tuple[CriticalMu, ...]:
    """Every μ > 0, at most `mu_s`, at which the stability of sliding changes, ascending.

    Without coupling (k3 = 0) it is μ_s − c1 v_s/(P e^(−v/v_s)).
    """
    if p.mu_s is None or p.v_s is None or p.v_belt is None:
        return critical_mu_of_constant(p, separation=separation)
    if p.v_belt == 0.0 or (separation and load(p) < 0.0):
        return ()
    if p.k3 == 0.0:
        grip = _force_without_coupling(p) * math.exp(-p.v_belt / p.v_s)
        mu = p.mu_s - p.c1 * p.v_s / grip if grip > 0.0 and p.c2 > 0.0 else 0.0
        return (CriticalMu(mu, "stable"),) if 0.0 < mu < p.mu_s else ()
    top = min(p.mu_s, PARAMETERS["mu"].upper)
    found = _over_mu(p, p.v_belt / p.v_s, Fraction(p.mu_s)).changes()
    return tuple(CriticalMu(mu, becomes) for mu, becomes in found if 0.0 < mu <= top)


def critical_speeds(p: Parameters, *, separation: bool = True) -> tuple[CriticalSpeed, ...]:
    """Every belt speed above 0 at which the stability of sliding changes, ascending.

    Without coupling (k3 = 0) it is v_s ln(P (μ_s − μ)/(c1 v_s)).
    """
    fall, v_s, top = p.mu_static - p.mu, p.speed_law, parameter_spec("v_belt").upper
    if v_s is None or p.v_belt is None or (separation and load(p) < 0.0):
        return ()
    if p.k3 == 0.0:
        force = _force_without_coupling(p)
        excess = force * fall / (p.c1 * v_s) if p.c1 > 0.0 and p.c2 > 0.0 else math.inf
        if not 1.0 < excess < math.inf:
            return ()
        return (CriticalSpeed(v_s * math.log(excess), "stable"),)
    found = _over_speed(p, v_s).changes()
    return tuple(CriticalSpeed(v, becomes) for v, becomes in found if 0.0 < v <= top)


def _force_without_coupling(p: Parameters) -> float:
    return float(spring_force(p, resting_height(p, p.mu, separation=False)))


@dataclass(frozen=True, slots=True)
class _Family:
    # Equilibria by their height y: their friction coefficient, between two bounds, is
    # `friction`/(h P), what varies is a function of `unknown`/(`scale` P), given as numerator and
    # denominator, and C is `damping`/`scale`.
    p: Parameters
    bounds: tuple[Fraction, Fraction]
    unknown: Polynomial
    damping: Polynomial
    scale: Fraction
    reading: Callable[[int, int], float]

    def changes(self) -> list[tuple[float, Becomes]]:
        """Where stability changes, ascending, and what sliding becomes above."""
        ends = self._heights()
        if ends is None:
            return []
        force, friction = _balance(self.p)
        condition = self._condition(force, friction)
        signs = [integers(c)[0] for c in (*condition, force)]
        above, below = integers(self.unknown, product([self.scale], force))

        def at(y: Fraction) -> float:
            return self.reading(value_at(above, y), value_at(below, y))

        def is_stable(y: Fraction) -> bool:
            a3, a1, last, pressing = (value_at(c, y) for c in signs)
            return a3 > 0 and a1 > 0 and (last > 0) == (pressing > 0) and last != 0

        found = []
        least = (ends[1] - ends[0]) * _MARGIN**2
        for left, right in real_roots(condition[-1], *ends, lambda one, two: at(one) == at(two)):
            width = max(right - left, least)
            found.append((at(left), is_stable(left - width), is_stable(right + width)))
        if at(ends[0]) > at(ends[1]):
            found = [(value, after, before) for value, before, after in reversed(found)]
        changed = [(value, after) for value, before, after in found if before is not after]
        return [(value, "stable" if after else "unstable") for value, after in changed]

    def _heights(self) -> tuple[Fraction, Fraction] | None:
        # Around those of the bounds, no further than these are apart; None where stability does not
        # change: no friction moves the slider, or nothing but friction that falls damps it.
        p, (low, high) = self.p, self.bounds
        downward = load(p)
        if downward == 0.0 or low == high or (downward > 0.0 and p.c1 == p.c2 == 0.0):
            return None
        h, sign = coupling_stiffness(p.exact()), (1 if downward > 0.0 else -1)
        force, friction = _balance(p)
        span = high - low

        def bracket(bound: Fraction, outside: int) -> Fraction:
            # A height whose friction is beyond the bound by less than the span.
            excess, far = integers(
                total(friction, product([-bound * h], force)),
                total(friction, product([-(bound + outside * span) * h], force)),
            )
            y = Fraction(resting_height(p, float(bound), separation=False))
            step = _MARGIN * abs(y)
            ends = [y, y]
            for place, towards in ((0, outside), (1, -outside)):
                # |y| falls as friction grows.
                while value_at(excess, ends[place]) * sign * towards <= 0:
                    ends[place] += step * sign * towards
                    step *= 2
            while value_at(far, ends[0]) * sign * outside >= 0:
                middle = (ends[0] + ends[1]) / 2
                ends[int(value_at(excess, middle) * sign * outside <= 0)] = middle
            return ends[0]

        found = bracket(low, -1), bracket(high, 1)
        return min(found), max(found)

    def _condition(
        self, force: Polynomial, friction: Polynomial
    ) -> tuple[Polynomial, Polynomial, Polynomial]:
        # a3 and a1, both times the scale, and P times the last condition of Hurwitz.
        p, scale = self.p, [self.scale]
        exact = p.exact()
        m, c2 = [exact.m], [exact.c2]
        h, a = [coupling_stiffness(exact)], [horizontal_stiffness(exact)]
        kt = [exact.k2, Fraction(0), 3 * exact.k_nl]
        b = total(kt, h)
        c1 = self.damping
        a3 = product(m, total(c1, product(c2, scale)))
        a2 = total(product(scale, m, total(a, b)), product(c1, c2))
        a1 = total(product(c1, b), product(scale, c2, a))
        a0 = total(
            product(total(product(a, b), product(_LESS, h, h)), force), product(friction, kt)
        )
        pairs = total(product(a3, a2), product(_LESS, m, m, scale, a1))
        last = total(product(a1, pairs, force), product(_LESS, scale, a3, a3, a0))
        return a3, a1, last


def _over_mu(p: Parameters, exponent: float, top: Fraction) -> _Family:
    # Over μ from 0 to μ_s, at a speed of the belt.
    rest = Fraction(-math.expm1(-exponent))
    share, v_s, h = 1 - rest, Fraction(p.v_s or 0.0), coupling_stiffness(p.exact())
    force, friction = _balance(p)
    held, scale = product([h * top], force), h * rest * v_s
    return _Family(
        p,
        (top * share, top),
        product([v_s], total(friction, product([-share], held))),
        total([Fraction(p.c1) * scale], product([-share], held), product([share], friction)),
        scale,
        _ratio,
    )


def _over_speed(p: Parameters, v_s: float) -> _Family:
    # Over the speed of the belt, by e from 0 to 1.
    h, mu, top = coupling_stiffness(p.exact()), Fraction(p.mu), Fraction(p.mu_static)
    force, friction = _balance(p)
    scale = h * Fraction(v_s)
    more = total(friction, product([-h * mu], force))

    def speed(above: int, below: int) -> float:
        if below < 0:
            above, below = -above, -below
        if above << _LEAST_SHARE < below:
            return math.inf
        if above >= below:
            return 0.0
        share = above / below
        if share < sys.float_info.min:
            return v_s * (math.log(below) - math.log(above))
        return -v_s * (math.log(share) if share < _HALF else math.log1p(-(below - above) / below))

    return _Family(
        p,
        (mu, top),
        product([Fraction(v_s) / (top - mu)], more),
        total([Fraction(p.c1) * scale], product(_LESS, more)),
        scale,
        speed,
    )


def _ratio(above: int, below: int) -> float:
    try:
        return above / below
    except OverflowError:
        return math.inf if (above > 0) == (below > 0) else -math.inf


def _balance(p: Parameters) -> tuple[Polynomial, Polynomial]:
    # P, and h μ_b P, as polynomials in y.
    exact = p.exact()
    a, h = horizontal_stiffness(exact), coupling_stiffness(exact)
    force = [Fraction(0), -exact.k2, Fraction(0), -exact.k_nl]
    return force, total([a * load(exact), h * exact.k1], product([-a], force))

"""Stability of many parameter sets at once, on arrays and in closed form.

The equilibrium is that of `model.equilibrium`. Eigenvalues follow from the resolvent cubic of the
characteristic quartic, the stability boundary from the Routh–Hurwitz criterion.
"""

import contextlib
from collections.abc import Collection, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    PARAMETERS,
    ComputationError,
    InputError,
    Parameters,
    System,
    check_has_verdict,
    coupling_stiffness,
    flutter_boundary,
    flutter_boundary_slope,
    horizontal_stiffness,
    is_on_edge,
    load,
    rest_coefficients,
    spring_force,
    suspension_stiffness,
    tangent_slope,
    tangent_stiffness,
)

from .belt import critical_mu_on_belt
from .eigenvalues import ROUNDING, growth_and_stability
from .heights import resting_heights
from .quartic import rightmost_real_part

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_MAX_ITERATIONS: Final = 200
# Relative change of μ at which an iteration has converged.
_CONVERGED: Final = 4.0 * np.finfo(float).eps


class StabilityPoints:
    """Growth rate, stability boundary and critical μ of n parameter sets at their equilibria.

    Use it under ``np.errstate(all="ignore")`` and check for values that are not finite.
    `separation` is True where the slider may leave the belt. `h` = k3/2 and `a` = k1 + h are
    stiffnesses, N/m; `load` is the preload F, N. `lifted` is True where F < 0 lifts the slider off
    the belt, `no_verdict` where moreover no spring holds it, and at F = 0 with separation. `kt` is
    the tangent contact stiffness, N/m, 0 where the slider is lifted.
    """

    m: FloatArray
    k2: FloatArray
    k3: FloatArray
    c1: FloatArray
    c2: FloatArray
    mu: FloatArray

    def __init__(
        self, p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
    ) -> None:
        size = separation.size
        # All parameters become attributes, which the functions of the model read.
        vars(self).update(
            {name: varied.get(name, np.full(size, getattr(p, name))) for name in PARAMETERS}
        )
        self.h: FloatArray = coupling_stiffness(self)
        self.a: FloatArray = horizontal_stiffness(self)
        self.load: FloatArray = load(self)
        self.lifted = (self.load < 0.0) & separation
        with np.errstate(all="ignore"):
            stiffness = suspension_stiffness(self)
            is_free = (stiffness == 0.0) | ~np.isfinite(self.load / stiffness)
            self.no_verdict: BoolArray = (self.lifted & is_free) | is_on_edge(self, separation)
            self.kt = np.where(self.lifted, 0.0, self._tangent_stiffness(self.mu))

    def growth_rate(self) -> FloatArray:
        """Greatest real part of the eigenvalues, 1/s, shape (n,).

        Undefined where `no_verdict`.
        """
        # The characteristic quartic is (s² + c1 s + a)(s² + c2 s + b) − d. With s in units of
        # √(stiffness/m) every coefficient is of order one.
        b = self.kt + self.h
        stiffness = self.a + b
        scale = np.sqrt(self.m * stiffness)
        coupling = self.h - self.mu * self.kt
        return rightmost_real_part(
            c1=self.c1 / scale,
            a=self.a / stiffness,
            c2=self.c2 / scale,
            b=b / stiffness,
            d=self.h * coupling / stiffness / stiffness,
        ) * np.sqrt(stiffness / self.m)

    def _eigenvalue_bound(self) -> FloatArray:
        # Upper bound of the moduli of the eigenvalues, 1/s, of their order of magnitude.
        stiffness = self.a + self.kt + self.h
        return np.sqrt(stiffness) / np.sqrt(self.m) + (self.c1 + self.c2) / self.m

    def growth_and_stability(self) -> tuple[FloatArray, BoolArray]:
        """`growth_rate`, and whether it is negative beyond rounding; shape (n,) each."""
        growth = self.growth_rate()
        return growth, growth < -ROUNDING * self._eigenvalue_bound()

    def excess(self) -> FloatArray:
        """Relative excess of μ h k_t over its value on the stability boundary, shape (n,).

        Negative where stable, −1 without friction coupling, NaN where `no_verdict`.
        """
        coupling = self.mu * self.h * self.kt
        boundary = flutter_boundary(self, self.kt)
        relative = (
            np.divide(coupling, boundary, out=np.zeros_like(coupling), where=boundary > 0.0) - 1.0
        )
        relative[self.no_verdict] = np.nan
        return relative

    def _tangent_stiffness(self, mu: FloatArray) -> FloatArray:
        return tangent_stiffness(self, resting_heights(self, mu))

    def critical_mu(self) -> FloatArray:
        """The μ above which the equilibrium is unstable, shape (n,); NaN if none is in range."""
        # Newton's method on the distance from the boundary, which grows with μ. A step that leaves
        # the bracket is replaced by bisection on a logarithmic scale.
        low, high = np.zeros_like(self.m), np.full_like(self.m, PARAMETERS["mu"].upper)
        is_missing = self.lifted | self.no_verdict | (self.k3 == 0.0)
        is_missing |= (self._distance(low)[0] >= 0.0) | (self._distance(high)[0] < 0.0)
        with np.errstate(all="ignore"):
            # Start from the critical μ of the linear system, whose contact stiffness is k2.
            mu = np.clip(flutter_boundary(self, self.k2) / (self.h * self.k2), 0.0, high)
        active = ~is_missing
        for _ in range(_MAX_ITERATIONS):
            distance, slope = self._distance(mu)
            below = distance < 0.0
            low, high = np.where(below, mu, low), np.where(below, high, mu)
            next_mu = mu - distance / slope
            outside = ~((next_mu > low) & (next_mu < high))
            middle = np.where(low > 0.0, np.sqrt(low * high), 0.5 * (low + high))
            next_mu = np.where(outside, middle, next_mu)
            has_moved = np.abs(next_mu - mu) > _CONVERGED * mu
            # Converged sets stay unchanged, so that no result depends on other sets of the batch.
            mu = np.where(active, next_mu, mu)
            active &= has_moved & (high - low > _CONVERGED * high)
            if not active.any():
                break
        return np.where(is_missing, np.nan, mu)

    def _distance(self, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
        # μ − boundary/(h k_t) and its derivative by μ; k_t follows from the equilibrium for each μ.
        y = resting_heights(self, mu)
        # The cubic α y³ + β y + F = 0 for y gives dy/dμ = (h/a) P/(3 α y² + β).
        alpha, beta, _ = rest_coefficients(self, mu)
        kt = tangent_stiffness(self, y)
        force_slope = self.h / self.a * spring_force(self, y)
        kt_slope = tangent_slope(self, y) * force_slope / (3.0 * alpha * y * y + beta)
        boundary = flutter_boundary(self, kt)
        slope = flutter_boundary_slope(self, kt)
        coupling = self.h * kt
        return mu - boundary / coupling, 1.0 - (slope - boundary / kt) / coupling * kt_slope


def critical_mus(
    p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
) -> FloatArray:
    """Critical friction coefficients of n parameter sets, shape (n,); NaN where there is none.

    NaN also where `reasons_without_verdict` has a reason.
    The equilibrium becomes unstable above it. On a belt of finite speed (with a value of `v_belt`;
    else the belt is always faster than the slider) there may be several; the least one counts.
    """
    if has_finite_speed(p, varied):
        return _critical_mus_on_belt(p, varied, separation)
    with np.errstate(all="ignore"):
        return StabilityPoints(p, varied, separation).critical_mu()


def has_finite_speed(p: Parameters, varied: Collection[str]) -> bool:
    """Whether parameter sets have a belt of finite speed."""
    return p.v_belt is not None or "v_belt" in varied


def _critical_mus_on_belt(
    p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
) -> FloatArray:
    # Critical μ does not depend on the value of μ. It is 0 here, as it must not exceed the static
    # friction coefficient μ_s.
    critical = np.full(separation.size, np.nan)
    for index, separates in enumerate(separation.tolist()):
        values = {name: float(column[index]) for name, column in varied.items()}
        system = System(p.with_values({**values, "mu": 0.0}), separates)
        with contextlib.suppress(ComputationError):
            critical[index] = next(
                (c.mu for c in critical_mu_on_belt(system) if c.becomes == "unstable"), np.nan
            )
    return critical


def reasons_without_verdict(
    p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
) -> dict[int, str]:
    """Why eigenvalues decide nothing at any μ, by the index of a parameter set."""
    columns: Any = p.replaced(**varied)
    reasons: dict[int, str] = {}
    for index in np.flatnonzero(is_on_edge(columns, separation) | (columns.v_belt == 0.0)).tolist():
        values = {name: float(column[index]) for name, column in varied.items()}
        try:
            check_has_verdict(System(p.with_values({**values, "mu": 0.0}), bool(separation[index])))
        except ComputationError as error:
            reasons[index] = str(error)
    return reasons


def judge_stability(
    p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
) -> tuple[FloatArray, BoolArray, dict[int, str]]:
    """Growth rates and stability of n parameter sets, and why some have no verdict."""
    if has_finite_speed(p, varied):
        return _growths_on_belt(p, varied, separation)
    with np.errstate(all="ignore"):
        points = StabilityPoints(p, varied, separation)
        growth, stable = points.growth_and_stability()
    reasons: dict[int, str] = {}
    for index in np.flatnonzero(points.no_verdict).tolist():
        values = p.with_values({name: float(column[index]) for name, column in varied.items()})
        growth[index], stable[index] = np.nan, False
        try:
            # The error says why there is no verdict.
            growth_and_stability(System(values, bool(separation[index])))
        except ComputationError as error:
            reasons[index] = str(error)
    return growth, stable, reasons


def _growths_on_belt(
    p: Parameters, varied: Mapping[str, FloatArray], separation: BoolArray
) -> tuple[FloatArray, BoolArray, dict[int, str]]:
    # On a belt of finite speed stability follows from the eigenvalues of every set.
    size = separation.size
    growth, stable = np.full(size, np.nan), np.zeros(size, dtype=bool)
    reasons: dict[int, str] = {}
    for index, separates in enumerate(separation.tolist()):
        try:
            parameters = p.with_values(
                {name: float(column[index]) for name, column in varied.items()}
            )
            growth[index], stable[index] = growth_and_stability(System(parameters, separates))
        except (ComputationError, InputError) as error:
            reasons[index] = str(error)
    return growth, stable, reasons

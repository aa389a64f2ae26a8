"""Derivatives of the critical friction coefficient by parameters, in closed form."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from fivtui.model import PARAMETERS, Parameters, equilibrium

from .critical import boundary, critical_mu

# An imaginary step, whose square is nothing beside 1: f(x + ih) = f(x) + ih f′(x).
_STEP: Final = 1e-40


def critical_mu_derivatives(p: Parameters, *, separation: bool = True) -> dict[str, float] | None:
    """Derivatives of μ_c by the parameters but μ, per unit of each; None if there is no μ_c.

    None, too, where friction falls with the sliding speed.

    The equilibrium y and μ_c solve two equations in closed form. Their derivatives, taken by
    imaginary steps, are exact to rounding, and the implicit function theorem gives those of μ_c.
    By dampings, where both are zero, there are none: NaN.
    """
    found = critical_mu(p, separation=separation)
    if not found or (p.v_belt is not None and p.speed_law is not None):
        return None
    mu = found[0].mu
    y = equilibrium(p, separation=False, mu=mu).y
    values = dict(p.as_dict())
    solved = np.array([
        _derivatives(values, y, mu, unknown) for unknown in ("y", "mu")
    ]).T  # fmt: skip
    by = {}
    for name in PARAMETERS:
        if name == "mu":
            continue
        given = np.array(_derivatives(values, y, mu, name))
        by[name] = float(np.linalg.solve(solved, -given)[1])
        if name in ("c1", "c2") and p.c1 + p.c2 == 0.0:
            by[name] = np.nan
    return by


def _derivatives(values: dict[str, float], y: float, mu: float, by: str) -> Sequence[float]:
    step = 1j * _STEP
    given: dict[str, Any] = {**values, "mu": mu, "y": y}
    given[by] = given[by] + step
    return [part.imag / _STEP for part in _residuals(given)]


def _residuals(v: dict[str, Any]) -> tuple[Any, Any]:
    # Rest under the preload, and μ h k_t less the boundary; both are zero at the critical μ.
    h = 0.5 * v["k3"]
    a = v["k1"] + h
    y, mu, damping = v["y"], v["mu"], v["c1"] + v["c2"]
    friction = 1.0 + mu * h / a
    rest = friction * (v["k_nl"] * y * y * y + v["k2"] * y) + h * v["k1"] / a * y + v["F"]
    kt = v["k2"] + 3.0 * v["k_nl"] * y * y
    share = v["c1"] / damping if damping != 0.0 else 0.5
    bound = boundary(m=v["m"], k1=v["k1"], k3=v["k3"], c1=v["c1"], c2=v["c2"], kt=kt, share=share)
    return 0j + rest, 0j + mu * h * kt - bound

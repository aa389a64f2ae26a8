"""Derivatives of the critical friction coefficient by parameters, in closed form."""

from collections.abc import Collection

import numpy as np

from fivtui.model import (
    DERIVATIVE_STEP,
    PARAMETERS,
    Parameters,
    System,
    coupling_stiffness,
    derivative,
    equilibrium,
    flutter_boundary,
    rest_coefficients,
    tangent_stiffness,
)

from .critical import critical_mu


def critical_mu_derivatives(
    system: System, names: Collection[str] = tuple(PARAMETERS)
) -> dict[str, float] | None:
    """Derivatives of μ_c by parameters but μ, per unit of each; None if there is no μ_c.

    None, too, where friction falls with the sliding speed.

    The equilibrium y and μ_c solve two equations in closed form. Their derivatives, taken by
    imaginary steps, are exact to rounding, and the implicit function theorem gives those of μ_c.
    By dampings, where both are zero, there are none: NaN.
    """
    p, critical = system.parameters, critical_mu(system)
    if not critical or (p.v_belt is not None and p.speed_law is not None):
        return None
    mu = critical[0].mu
    y = equilibrium(System(p, separation=False), mu=mu).y
    still = p.perturbed({})
    step = complex(0.0, DERIVATIVE_STEP)
    solved = np.array([_derivatives(still, y + step, mu), _derivatives(still, y, mu + step)]).T
    by = {}
    for name in names:
        if name == "mu":
            continue
        changed = np.array(_derivatives(p.perturbed({name: 1.0}), y, mu))
        by[name] = float(np.linalg.solve(solved, -changed)[1])
        if name in ("c1", "c2") and p.c1 + p.c2 == 0.0:
            by[name] = np.nan
    return by


def _derivatives(p: Parameters, y: complex, mu: complex) -> tuple[float, float]:
    # Of rest under the load, and of μ h k_t less the boundary: both are zero at the critical μ.
    alpha, beta, load = rest_coefficients(p, mu)
    kt = tangent_stiffness(p, y)
    return (
        derivative(alpha * y * y * y + beta * y + load),
        derivative(mu * coupling_stiffness(p) * kt - flutter_boundary(p, kt)),
    )

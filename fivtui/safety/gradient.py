"""Derivatives of the safe friction coefficient by parameters."""

from typing import Final

import numpy as np

from fivtui.equilibrium import critical_mu_derivatives, lowest_critical_mu
from fivtui.model import PARAMETERS, ComputationError, System
from fivtui.orbits import EventKind, event_at
from fivtui.taylor import Seed
from fivtui.transient import START_SEEDS, Request, vary

from .least import branch_below, least_attracting

_AT_REST: Final = (0.0, 0.0, 0.0, 0.0)
_TOL: Final = 1e-13


def safe_mu_derivatives(system: System) -> dict[str, float] | None:
    """Derivatives of the safe μ by the parameters but μ, per unit of each.

    At a fold the equations of the periodic orbit, by state and period, are singular: their left
    null vector gives the derivatives from those of one period by μ and the parameters. Where no
    cycle attracts below the critical μ they are those of that one. None if there is no critical μ,
    or the branch ends or changes its stability otherwise at its least μ.
    """
    p, separation = system.parameters, system.separation
    critical = lowest_critical_mu(system)
    if critical is None:
        return None
    if not separation and p.k_nl == 0.0:
        return critical_mu_derivatives(system)
    found = branch_below(system, critical)
    least = least_attracting(found)
    if least is None or least.value >= critical:
        return critical_mu_derivatives(system)
    if event_at(found, least) is not EventKind.FOLD:
        return None
    names = [name for name in PARAMETERS if name != "mu"]
    seeds = [Seed(_AT_REST, {name: 1.0}) for name in ("mu", *names)]
    request = Request(
        system.with_values({"mu": least.value}),
        t_end=least.period,
        tol=_TOL,
        start=least.start,
    )
    flow = vary(request, [*START_SEEDS, *seeds])
    # In units in which displacements and velocities are alike.
    weights = np.array([1.0, least.period, 1.0, least.period])
    state = (flow.derivatives[:, :4] - np.eye(4)) * weights[:, None] / weights
    rate = flow.rate * weights
    left = np.linalg.svd(np.column_stack([state, rate / np.abs(rate).max()]))[0]
    null = left[:, -1] * weights
    by_mu, *by = (null @ flow.derivatives[:, 4:]).tolist()
    if by_mu == 0.0:
        raise ComputationError("the fold has no direction", "change a parameter a little")
    return {name: -each / by_mu for name, each in zip(names, by, strict=True)}

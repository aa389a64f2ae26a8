"""Least friction at which a limit cycle of the branch from the Hopf point attracts.

In units of m, k1 and the load the motion depends only on μ and five dimensionless groups.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import critical_mu_derivatives, lowest_critical_mu
from fivtui.model import (
    PARAMETERS,
    ComputationError,
    Parameters,
    System,
    check_always_sliding,
    coupling_stiffness,
    load,
)
from fivtui.orbits import CycleBranch, CyclePoint, EventKind, branch, event_at
from fivtui.taylor import Seed
from fivtui.transient import START_SEEDS, Request, vary

Floats = NDArray[np.float64]

# Stiffnesses over k1, dampings over √(m k1), and k_nl load²/k1³.
GROUPS: Final = ("k2", "k3", "c1", "c2", "k_nl")
# Upper end of branches, in critical μ.
_ABOVE: Final = 2.0
_CACHE_SIZE: Final = 65_536
_AT_REST: Final = (0.0, 0.0, 0.0, 0.0)
_TOL: Final = 1e-13


def groups_of(p: Parameters, varied: Mapping[str, Floats], size: int) -> Floats:
    """The groups of `size` parameter sets, shape (n, 5); NaN without a pressing load or k3."""
    check_always_sliding(
        p, "safe friction of many scenes; their critical friction is known", varied
    )
    sets = SimpleNamespace(
        **{
            name: np.asarray(varied.get(name, np.full(size, getattr(p, name))))
            for name in PARAMETERS
        }
    )
    groups = np.stack(_groups(sets), axis=1)
    groups[(load(sets) <= 0.0) | (coupling_stiffness(sets) == 0.0)] = np.nan
    return groups


def _groups(p: Any) -> list[Any]:
    damping = np.sqrt(p.m * p.k1)
    cubic = p.k_nl / p.k1 * (load(p) / p.k1) ** 2
    return [p.k2 / p.k1, p.k3 / p.k1, p.c1 / damping, p.c2 / damping, cubic]


def _parameters_by_group() -> dict[str, tuple[str, ...]]:
    # Nonzero values, so that every parameter of a product shows.
    base = Parameters().with_values({n: s.default or 1.0 for n, s in PARAMETERS.items()})
    changes = {name: _groups(base.perturbed({name: 1.0})) for name in PARAMETERS}
    return {
        group: tuple(name for name, change in changes.items() if change[index].imag != 0.0)
        for index, group in enumerate(GROUPS)
    }


# The parameters on which each group depends.
MADE_OF: Final[Mapping[str, Sequence[str]]] = _parameters_by_group()


@lru_cache(maxsize=_CACHE_SIZE)
def least_of(group: tuple[float, ...], *, separation: bool) -> float:
    """The least μ at which a cycle of the branch attracts, or the critical μ if that is lower.

    NaN if there is no critical μ, or the branch cannot be followed.
    """
    values = dict(zip(GROUPS, group, strict=True))
    p = Parameters(m=1.0, k1=1.0, F=1.0, mu=0.0).with_values(values)
    system = System(p, separation)
    critical = lowest_critical_mu(system)
    if critical is None:
        return np.nan
    if not separation and p.k_nl == 0.0:
        return critical
    try:
        cycles = branch_below(system, critical)
    except ComputationError:
        return np.nan
    least = least_attracting(cycles)
    return critical if least is None else min(critical, least.value)


def branch_below(system: System, critical: float) -> CycleBranch:
    """The branch that begins at the critical μ, up to twice the critical μ."""
    top = min(_ABOVE * critical, PARAMETERS["mu"].upper)
    at = system.parameters.with_values({"mu": critical})
    return branch(at, "mu", low=0.0, high=top, separation=system.separation)


def least_attracting(cycles: CycleBranch) -> CyclePoint | None:
    """The cycle of least μ among attracting cycles and the events next to them."""
    points = cycles.points
    attracting = [
        point
        for index, point in enumerate(points)
        if point.stable
        or (
            event_at(cycles, point) is not None
            and any(neighbour.stable for neighbour in points[max(index - 1, 0) : index + 2])
        )
    ]
    return min(attracting, key=lambda point: point.value, default=None)


def safe_mu_derivatives(system: System) -> dict[str, float] | None:
    """Derivatives of the safe μ by the parameters but μ, per unit of each.

    At a fold the equations of the periodic orbit, by state and period, are singular. Their left
    null vector gives the derivatives from those of one period by μ and the parameters. If no cycle
    attracts below the critical μ, the derivatives are those of the critical μ. None without a
    critical μ, or if the least μ of the branch is not at a fold.
    """
    p, separation = system.parameters, system.separation
    critical = lowest_critical_mu(system)
    if critical is None:
        return None
    if not separation and p.k_nl == 0.0:
        return critical_mu_derivatives(system)
    cycles = branch_below(system, critical)
    least = least_attracting(cycles)
    if least is None or least.value >= critical:
        return critical_mu_derivatives(system)
    if event_at(cycles, least) is not EventKind.FOLD:
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
    # Weights give displacements and velocities the same unit.
    weights = np.array([1.0, least.period, 1.0, least.period])
    state = (flow.derivatives[:, :4] - np.eye(4)) * weights[:, None] / weights
    rate = flow.final_rate * weights
    left_vectors = np.linalg.svd(np.column_stack([state, rate / np.abs(rate).max()]))[0]
    null = left_vectors[:, -1] * weights
    by_mu, *by = (null @ flow.derivatives[:, 4:]).tolist()
    if by_mu == 0.0:
        raise ComputationError("the fold has no direction", "change a parameter a little")
    return {name: -slope / by_mu for name, slope in zip(names, by, strict=True)}

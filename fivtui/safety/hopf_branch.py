"""Safe μ by continuation: the least μ of stable limit cycles on the branch from the Hopf point.

In units of m, k1 and the load, motion depends only on μ and five dimensionless groups.
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
from fivtui.transient import START_SEEDS, Request, compute_variation

Floats = NDArray[np.float64]

# Groups, named after a parameter: stiffnesses over k1, dampings over √(m k1), and k_nl load²/k1³.
GROUPS: Final = ("k2", "k3", "c1", "c2", "k_nl")
# Upper end of a branch, relative to the critical μ.
_UPPER_END: Final = 2.0
# Number of parameter sets, in dimensionless form, whose safe μ is cached.
_CACHE_SIZE: Final = 65_536
_NO_START_DEVIATION: Final = (0.0, 0.0, 0.0, 0.0)
# Tolerance of the run over the period of a fold.
_TOL: Final = 1e-13


def dimensionless_groups(p: Parameters, varied: Mapping[str, Floats], count: int) -> Floats:
    """The groups of `count` parameter sets, shape (n, 5); NaN where k3 = 0 or no load presses."""
    # Raises `InputError` for a belt of finite speed, on which motion depends on further groups.
    check_always_sliding(p, "safe friction of many scenes; critical_mu can be computed", varied)
    sets = SimpleNamespace(
        **{
            name: np.asarray(varied.get(name, np.full(count, getattr(p, name))))
            for name in PARAMETERS
        }
    )
    groups = np.stack(_group_values(sets), axis=1)
    # Stiffness k3 couples x and y: without it there is no flutter, hence no critical μ.
    groups[(load(sets) <= 0.0) | (coupling_stiffness(sets) == 0.0)] = np.nan
    return groups


def _group_values(p: Any) -> list[Any]:
    # The groups of parameters, which may be numbers, columns or numbers with derivatives.
    damping = np.sqrt(p.m * p.k1)
    cubic = p.k_nl / p.k1 * (load(p) / p.k1) ** 2
    return [p.k2 / p.k1, p.k3 / p.k1, p.c1 / damping, p.c2 / damping, cubic]


def _parameters_by_group() -> dict[str, tuple[str, ...]]:
    # Values must not be zero: a factor of zero hides the other parameters of a product.
    values = {name: spec.default or 1.0 for name, spec in PARAMETERS.items()}
    base = Parameters().with_values(values)
    # `perturbed` gives a parameter an imaginary part, and with it every group that depends on it.
    perturbed_groups = {name: _group_values(base.perturbed({name: 1.0})) for name in PARAMETERS}
    return {
        group: tuple(name for name, groups in perturbed_groups.items() if groups[index].imag != 0.0)
        for index, group in enumerate(GROUPS)
    }


# The parameters on which each group depends.
GROUP_PARAMETERS: Final[Mapping[str, Sequence[str]]] = _parameters_by_group()


@lru_cache(maxsize=_CACHE_SIZE)
def least_cycle_mu(groups: tuple[float, ...], *, separation: bool) -> float:
    """The least μ at which a cycle of the branch is stable, or the critical μ if that is less.

    `groups` has the values of `GROUPS`. NaN without a critical μ, or if the branch cannot be
    followed.
    """
    values = dict(zip(GROUPS, groups, strict=True))
    p = Parameters(m=1.0, k1=1.0, F=1.0, mu=0.0).with_values(values)
    system = System(p, separation)
    critical = lowest_critical_mu(system)
    if critical is None:
        return np.nan
    if _is_linear(system):
        return critical
    try:
        cycles = follow_hopf_branch(system, critical)
    except ComputationError:
        return np.nan
    cycle = least_attracting_cycle(cycles)
    return critical if cycle is None else min(critical, cycle.value)


def _is_linear(system: System) -> bool:
    # Linear systems have no limit cycles.
    return not system.separation and system.parameters.k_nl == 0.0


def follow_hopf_branch(system: System, critical: float) -> CycleBranch:
    """The branch from the Hopf point at the critical μ, up to twice the critical μ."""
    upper_mu = min(_UPPER_END * critical, PARAMETERS["mu"].upper)
    at_critical = system.parameters.with_values({"mu": critical})
    return branch(at_critical, "mu", low=0.0, high=upper_mu, separation=system.separation)


def least_attracting_cycle(cycles: CycleBranch) -> CyclePoint | None:
    """The cycle of least μ among stable cycles and the events beside them; None without any.

    At an event such as a fold the cycle is not stable itself: it is the limit of stable cycles.
    """
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
    """Derivatives of the safe μ with respect to all parameters but μ, per unit of each.

    At a fold the Jacobian of the periodicity equations, in state and period, is singular. Its left
    null vector, times their derivatives by μ and the parameters, gives the result. If no cycle is
    stable below the critical μ, the result has the derivatives of the critical μ. None without a
    critical μ, or if the least μ of the branch is not at a fold.
    """
    critical = lowest_critical_mu(system)
    if critical is None:
        return None
    if _is_linear(system):
        return critical_mu_derivatives(system)
    cycles = follow_hopf_branch(system, critical)
    cycle = least_attracting_cycle(cycles)
    if cycle is None or cycle.value >= critical:
        return critical_mu_derivatives(system)
    if event_at(cycles, cycle) is not EventKind.FOLD:
        return None
    names = [name for name in PARAMETERS if name != "mu"]
    seeds = [Seed(_NO_START_DEVIATION, {name: 1.0}) for name in ("mu", *names)]
    request = Request(
        system.with_values({"mu": cycle.value}),
        t_end=cycle.period,
        tol=_TOL,
        start=cycle.start,
    )
    variation = compute_variation(request, [*START_SEEDS, *seeds])
    # Velocities times the period have the unit of displacements.
    weights = np.array([1.0, cycle.period, 1.0, cycle.period])
    by_start, by_parameter = np.split(variation.derivatives, [len(START_SEEDS)], axis=1)
    # Rows of the Jacobian are for the state after a period, columns for the state at the start and
    # the period. The weights give components of states equal units.
    by_state = (by_start - np.eye(4)) * weights[:, None] / weights
    by_period = variation.final_rate * weights
    jacobian = np.column_stack([by_state, by_period / np.abs(by_period).max()])
    left_vectors, _, _ = np.linalg.svd(jacobian)
    # The last left vector belongs to the least singular value, 0 at a fold. Times the weights, it
    # applies to rows in units of the state.
    left_null_vector = left_vectors[:, -1] * weights
    mu_slope, *slopes = (left_null_vector @ by_parameter).tolist()
    if mu_slope == 0.0:
        raise ComputationError(
            "the fold is degenerate: safe μ has no derivatives", "change a parameter a little"
        )
    return {name: -slope / mu_slope for name, slope in zip(names, slopes, strict=True)}

"""Least friction at which a limit cycle of the branch from the Hopf point attracts.

In units of m, k1 and the load the motion depends on six numbers alone: these groups, and μ.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import lowest_critical_mu
from fivtui.model import (
    PARAMETERS,
    ComputationError,
    Parameters,
    System,
    check_always_sliding,
    coupling_stiffness,
    load,
)
from fivtui.orbits import CycleBranch, CyclePoint, branch, event_at

Floats = NDArray[np.float64]

# Stiffnesses by k1, dampings by √(m k1), and k_nl load²/k1³.
GROUPS: Final = ("k2", "k3", "c1", "c2", "k_nl")
# How far above the critical μ branches are followed, over it.
_ABOVE: Final = 2.0
_KEPT: Final = 65_536


def groups_of(p: Parameters, varied: Mapping[str, Floats], size: int) -> Floats:
    """The groups of `size` parameter sets, shape (n, 5); NaN where F presses not or k3 = 0."""
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
    # Where no default of zero hides a product.
    base = Parameters().with_values({n: s.default or 1.0 for n, s in PARAMETERS.items()})
    changes = {name: _groups(base.perturbed({name: 1.0})) for name in PARAMETERS}
    return {
        group: tuple(name for name, change in changes.items() if change[index].imag != 0.0)
        for index, group in enumerate(GROUPS)
    }


# The parameters that decide on each group.
MADE_OF: Final[Mapping[str, Sequence[str]]] = _parameters_by_group()


@lru_cache(maxsize=_KEPT)
def least_of(group: tuple[float, ...], *, separation: bool) -> float:
    """The least μ at which a cycle of the branch attracts, or the critical one if that is less.

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
        found = branch_below(system, critical)
    except ComputationError:
        return np.nan
    least = least_attracting(found)
    return critical if least is None else min(critical, least.value)


def branch_below(system: System, critical: float) -> CycleBranch:
    """The branch that begins at the critical μ, up to twice that."""
    top = min(_ABOVE * critical, PARAMETERS["mu"].upper)
    at = system.parameters.with_values({"mu": critical})
    return branch(at, "mu", low=0.0, high=top, separation=system.separation)


def least_attracting(found: CycleBranch) -> CyclePoint | None:
    """The cycle of least μ that attracts, or at which stability is lost: a fold is neither."""
    points = found.points
    attracting = [
        point
        for index, point in enumerate(points)
        if point.stable
        or (
            event_at(found, point) is not None
            and any(neighbour.stable for neighbour in points[max(index - 1, 0) : index + 2])
        )
    ]
    return min(attracting, key=lambda point: point.value, default=None)

"""Where branches of limit cycles begin."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import (
    ComputationError,
    InputError,
    Parameters,
    Progress,
    State,
    System,
    accelerations,
    equilibrium,
    mode_of,
)
from fivtui.orbits.explorer import Explorer, starts_around
from fivtui.orbits.rest import length_scale
from fivtui.orbits.shooting import PeriodicOrbit

from .arclength import VALUE, OrbitOnCurve
from .branch_curve import BranchCurve, slider_belt_curve
from .events import EventKind
from .hopf import HopfPoint, hopf_point, hopf_values
from .result import BranchEvent

# Amplitude at a Hopf point, relative to the static deflection.
FIRST: Final = 5e-3


@dataclass(frozen=True, slots=True)
class Beginning:
    """Where a branch is begun: a cycle of its curve, and the Hopf point that it is next to."""

    curve: BranchCurve
    start: OrbitOnCurve
    hopf: BranchEvent | None = None


def from_hopf(system: System, name: str, bounds: tuple[float, float], work: Progress) -> Beginning:
    """The branch from the Hopf point nearest to the parameter set, with its events and ends."""
    p = system.parameters
    if not _is_damped(p, name):
        raise ComputationError("without damping there is no Hopf point", "set c1 or c2 above 0")
    values = hopf_values(system, name, *bounds)
    if not values:
        raise ComputationError(
            f"no Hopf point with {name} from {bounds[0]:g} to {bounds[1]:g}",
            "widen the range, or begin at a limit cycle (--from cycle)",
        )
    value = min(values, key=lambda one: abs(one - getattr(p, name)))
    at = system.with_values({name: value})
    hopf, point = hopf_point(at, name), equilibrium(at)
    period = 2.0 * math.pi / hopf.omega
    if point.y == 0.0 and system.separation:
        raise ComputationError(
            f"the equilibrium is at y = 0 at the Hopf point {name} = {value:g}", "change F"
        )
    length = abs(point.y) or math.sqrt(at.parameters.k2 / at.parameters.k_nl)
    curve = slider_belt_curve(at, name, bounds, length, period, work=work)
    first = np.zeros(6)
    first[:4] = hopf.vector.real / curve.scales[:4] * length
    size = float(np.linalg.norm(first))
    rest = np.array([point.x, 0.0, point.y, 0.0, period, value]) / curve.scales
    across = np.zeros(6)
    across[:4] = (1j * hopf.vector).real / curve.scales[:4]
    planes = np.array([across / np.linalg.norm(across), first / size])
    start = curve.orbits.solve(rest + FIRST / size * first, planes)
    if start is None:
        raise ComputationError(
            f"no limit cycle was found next to the Hopf point {name} = {value:g}",
            "begin at a limit cycle (--from cycle)",
        )
    return Beginning(curve, start, hopf_event(at, hopf))


def _is_damped(p: Parameters, name: str) -> bool:
    # Somewhere along the branch; without damping there is no Hopf point.
    return max(p.c1, p.c2) > 0.0 or name in ("c1", "c2")


def _beginning_elsewhere(p: Parameters, name: str) -> str:
    hopf = ", or at a Hopf point (--from hopf)" if _is_damped(p, name) else ""
    return f"begin at another value{hopf}"


def from_cycle(system: System, name: str, bounds: tuple[float, float], work: Progress) -> Beginning:
    """The branch through the first limit cycle that transients reach, followed both ways."""
    value = getattr(system.parameters, name)
    if not bounds[0] <= value <= bounds[1]:
        raise InputError(f"{name} = {value:g}: must be in the range {bounds[0]:g} to {bounds[1]:g}")
    orbit = _first_cycle(Explorer(system, work=work), name)
    return through(system, name, bounds, work, (orbit.start, orbit.period))


def through(
    system: System,
    name: str,
    bounds: tuple[float, float],
    work: Progress,
    cycle: tuple[State, float],
) -> Beginning:
    """The branch through a limit cycle, given by a state and its period."""
    curve, start = cycle_near(system, name, bounds, work, cycle)
    if start is None:
        p = system.parameters
        raise ComputationError(
            f"the limit cycle at {name} = {getattr(p, name):g} cannot be followed",
            _beginning_elsewhere(p, name),
        )
    return Beginning(curve, start)


def cycle_near(
    system: System,
    name: str,
    bounds: tuple[float, float],
    work: Progress,
    cycle: tuple[State, float],
) -> tuple[BranchCurve, OrbitOnCurve | None]:
    """The curve of the cycles, and of a system the one near a state and its period."""
    p, (state, period) = system.parameters, cycle
    length = length_scale(system)
    curve = slider_belt_curve(system, name, bounds, length, period, work=work)
    ax, ay = accelerations(p, state, mode_of(p, state, separation=system.separation))
    planes = np.eye(6)[[0, VALUE]]
    planes[0, :4] = np.array([state[1], ax, state[3], ay]) / curve.scales[:4]
    planes[0] /= np.linalg.norm(planes[0])
    guess = np.array([*state, period, getattr(p, name)]) / curve.scales
    return curve, curve.orbits.solve(guess, planes)


def _first_cycle(explorer: Explorer, name: str) -> PeriodicOrbit:
    starts = starts_around(explorer)
    for start in starts:
        orbit = explorer.reach(start).orbit
        if orbit is not None:
            return orbit
    raise ComputationError(
        f"no limit cycle was found from {len(starts)} starts",
        _beginning_elsewhere(explorer.system.parameters, name),
    )


def hopf_event(system: System, hopf: HopfPoint) -> BranchEvent:
    """A Hopf point as an event of a branch."""
    y = equilibrium(system).y
    period = 2.0 * math.pi / hopf.omega
    return BranchEvent(EventKind.HOPF, hopf.value, period, y, y, hopf.direction)


def nearest_hopf(
    system: System, name: str, bounds: tuple[float, float], value: float
) -> list[BranchEvent]:
    """The Hopf point to which a branch has returned; none if it is beyond the range."""
    values = hopf_values(system, name, *bounds)
    if not values:
        return []
    at = system.with_values({name: min(values, key=lambda one: abs(one - value))})
    return [hopf_event(at, hopf_point(at, name))]

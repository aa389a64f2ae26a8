"""Where branches of limit cycles begin."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.model import (
    ComputationError,
    InputError,
    State,
    System,
    accelerations,
    equilibrium,
    mode_of,
)
from fivtui.orbits.explorer import Explorer, starts_around
from fivtui.orbits.rest import length_scale

from .arclength import VALUE, OrbitOnCurve
from .branch_curve import BranchCurve, ParameterLine
from .events import EventKind
from .hopf import HopfPoint, hopf_point, hopf_values
from .result import BranchEvent

# Amplitude at a Hopf point, relative to the static deflection.
FIRST: Final = 5e-3


@dataclass(frozen=True, slots=True)
class Beginning:
    """The beginning of a branch: a cycle of its curve, and the Hopf point next to it, if any."""

    curve: BranchCurve
    start: OrbitOnCurve
    hopf: BranchEvent | None = None


def from_hopf(line: ParameterLine) -> Beginning:
    """The beginning at the Hopf point nearest to the parameter set."""
    name, bounds = line.name, line.bounds
    if not _is_damped(line):
        raise ComputationError("without damping there is no Hopf point", "set c1 or c2 above 0")
    values = hopf_values(line.system, name, *bounds)
    if not values:
        raise ComputationError(
            f"no Hopf point with {name} from {bounds[0]:g} to {bounds[1]:g}",
            "widen the range, or begin at a limit cycle (--from cycle)",
        )
    line = line.at(min(values, key=lambda value: abs(value - line.value)))
    system, value = line.system, line.value
    hopf, point = hopf_point(system, name), equilibrium(system)
    period = 2.0 * math.pi / hopf.omega
    if point.y == 0.0 and system.separation:
        raise ComputationError(
            f"the equilibrium is at y = 0 at the Hopf point {name} = {value:g}", "change F"
        )
    length = abs(point.y) or math.sqrt(system.parameters.k2 / system.parameters.k_nl)
    curve = line.curve(length, period)
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
    return Beginning(curve, start, hopf_event(system, hopf))


def _is_damped(line: ParameterLine) -> bool:
    # Whether there is damping along the line; without it there is no Hopf point.
    p = line.system.parameters
    return max(p.c1, p.c2) > 0.0 or line.name in ("c1", "c2")


def _beginning_elsewhere(line: ParameterLine) -> str:
    hopf = ", or at a Hopf point (--from hopf)" if _is_damped(line) else ""
    return f"begin at another value{hopf}"


def from_cycle(line: ParameterLine) -> Beginning:
    """The beginning at the first limit cycle that transients reach."""
    low, high = line.bounds
    if not low <= line.value <= high:
        raise InputError(f"{line.name} = {line.value:g}: must be in the range {low:g} to {high:g}")
    explorer = Explorer(line.system, work=line.work)
    starts = starts_around(explorer)
    orbits = (explorer.reach(start).orbit for start in starts)
    orbit = next((orbit for orbit in orbits if orbit is not None), None)
    if orbit is None:
        raise ComputationError(
            f"no limit cycle was found from {len(starts)} starts", _beginning_elsewhere(line)
        )
    return through(line, (orbit.start, orbit.period))


def through(line: ParameterLine, cycle: tuple[State, float]) -> Beginning:
    """The beginning at a limit cycle, given by a state and its period."""
    curve, start = cycle_near(line, cycle)
    if start is None:
        raise ComputationError(
            f"the limit cycle at {line.name} = {line.value:g} cannot be followed",
            _beginning_elsewhere(line),
        )
    return Beginning(curve, start)


def cycle_near(
    line: ParameterLine, cycle: tuple[State, float]
) -> tuple[BranchCurve, OrbitOnCurve | None]:
    """The curve of cycles along a line, and the cycle near a state and its period."""
    system, (state, period) = line.system, cycle
    p = system.parameters
    curve = line.curve(length_scale(system), period)
    ax, ay = accelerations(p, state, mode_of(p, state, separation=system.separation))
    planes = np.eye(6)[[0, VALUE]]
    planes[0, :4] = np.array([state[1], ax, state[3], ay]) / curve.scales[:4]
    planes[0] /= np.linalg.norm(planes[0])
    guess = np.array([*state, period, line.value]) / curve.scales
    return curve, curve.orbits.solve(guess, planes)


def hopf_event(system: System, hopf: HopfPoint) -> BranchEvent:
    """A Hopf point as an event of a branch."""
    y = equilibrium(system).y
    period = 2.0 * math.pi / hopf.omega
    return BranchEvent(EventKind.HOPF, hopf.value, period, y, y, hopf.direction)


def nearest_hopf(line: ParameterLine, value: float) -> list[BranchEvent]:
    """The Hopf point at which a branch ends; empty if it is beyond the range."""
    values = hopf_values(line.system, line.name, *line.bounds)
    if not values:
        return []
    system = line.at(min(values, key=lambda hopf: abs(hopf - value))).system
    return [hopf_event(system, hopf_point(system, line.name))]

"""Starts of branches of limit cycles: at a Hopf point, at an attractor, or at a given cycle.

A `ParameterLine` is the parameter that varies, with its system and range; its `curve` has the
equations of the cycles along it.
"""

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
from fivtui.orbits.explorer import Explorer, standard_starts
from fivtui.orbits.rest import length_scale

from .arclength import PARAMETER, OrbitOnCurve
from .branch_curve import BranchCurve, ParameterLine
from .events import EventKind
from .hopf import HopfPoint, hopf_point, hopf_values
from .result import BranchEvent

# Amplitude of the first cycle at a Hopf point, relative to the static deflection.
FIRST_AMPLITUDE: Final = 5e-3
# Unknowns of an orbit: state, period and the parameter. The state comes first.
_UNKNOWN_COUNT: Final = 6
_STATE: Final = slice(0, 4)


@dataclass(frozen=True, slots=True)
class BranchStart:
    """The start of a branch: an orbit on its curve, and the Hopf point beside it, if any."""

    curve: BranchCurve
    orbit: OrbitOnCurve
    hopf: BranchEvent | None = None


def hopf_start(line: ParameterLine) -> BranchStart:
    """The start at the Hopf point nearest to the parameter set."""
    name, bounds = line.name, line.bounds
    if not _is_damped(line):
        raise ComputationError("without damping there is no Hopf point", "set c1 or c2 above 0")
    values = hopf_values(line.system, name, *bounds)
    if not values:
        raise ComputationError(
            f"no Hopf point with {name} from {bounds[0]:g} to {bounds[1]:g}",
            "widen the range, or begin at a limit cycle (--from cycle)",
        )
    line = line.with_value(min(values, key=lambda value: abs(value - line.value)))
    system, value = line.system, line.value
    hopf, point = hopf_point(system, name), equilibrium(system)
    period = 2.0 * math.pi / hopf.omega
    # The static deflection; if it is 0, the y at which linear and cubic contact force are equal.
    length = abs(point.y) or math.sqrt(system.parameters.k2 / system.parameters.k_nl)
    curve = line.curve(length, period)
    # The first cycle is an ellipse, spanned by the real and imaginary parts of the eigenvector.
    direction = np.zeros(_UNKNOWN_COUNT)
    direction[_STATE] = hopf.eigenvector.real / curve.scales[_STATE] * length
    size = float(np.linalg.norm(direction))
    rest = np.array([point.x, 0.0, point.y, 0.0, period, value]) / curve.scales
    flow_direction = np.zeros(_UNKNOWN_COUNT)
    flow_direction[_STATE] = (1j * hopf.eigenvector).real / curve.scales[_STATE]
    # Planes through the guess: the first fixes the phase, the second the amplitude.
    plane_normals = np.array([flow_direction / np.linalg.norm(flow_direction), direction / size])
    orbit = curve.orbits.solve(rest + FIRST_AMPLITUDE / size * direction, plane_normals)
    if orbit is None:
        raise ComputationError(
            f"no limit cycle was found next to the Hopf point {name} = {value:g}",
            "begin at a limit cycle (--from cycle)",
        )
    return BranchStart(curve, orbit, hopf_event(system, hopf))


def _is_damped(line: ParameterLine) -> bool:
    # Whether damping is above zero or varies; without damping there is no Hopf point.
    p = line.system.parameters
    return max(p.c1, p.c2) > 0.0 or line.name in ("c1", "c2")


def _advice_text(line: ParameterLine) -> str:
    # Advice where no branch begins at a limit cycle.
    hopf_advice = ", or at a Hopf point (--from hopf)" if _is_damped(line) else ""
    return f"begin at another value{hopf_advice}"


def attractor_start(line: ParameterLine) -> BranchStart:
    """The start at the first limit cycle that transients reach."""
    low, high = line.bounds
    if not low <= line.value <= high:
        raise InputError(f"{line.name} = {line.value:g}: must be in the range {low:g} to {high:g}")
    explorer = Explorer(line.system, work=line.work)
    starts = standard_starts(explorer)
    # Each start is followed to its attractor, which has an orbit only if it is a limit cycle.
    orbits = (explorer.reach(start).orbit for start in starts)
    orbit = next((orbit for orbit in orbits if orbit is not None), None)
    if orbit is None:
        raise ComputationError(
            f"no limit cycle was found from {len(starts)} starts", _advice_text(line)
        )
    return cycle_start(line, (orbit.start, orbit.period))


def cycle_start(line: ParameterLine, cycle: tuple[State, float]) -> BranchStart:
    """The start at a limit cycle, given by a state and the period."""
    curve, orbit = cycle_near(line, cycle)
    if orbit is None:
        raise ComputationError(
            f"the limit cycle at {line.name} = {line.value:g} cannot be followed",
            _advice_text(line),
        )
    return BranchStart(curve, orbit)


def cycle_near(
    line: ParameterLine, cycle: tuple[State, float]
) -> tuple[BranchCurve, OrbitOnCurve | None]:
    """The curve of cycles along a parameter, and its orbit near a state and a period."""
    system, (state, period) = line.system, cycle
    p = system.parameters
    curve = line.curve(length_scale(system), period)
    ax, ay = accelerations(p, state, mode_of(p, state, separation=system.separation))
    _, vx, _, vy = state
    # Planes through the guess: the first fixes the phase, the second the parameter.
    plane_normals = np.zeros((2, _UNKNOWN_COUNT))
    plane_normals[0, _STATE] = np.array([vx, ax, vy, ay]) / curve.scales[_STATE]
    plane_normals[0] /= np.linalg.norm(plane_normals[0])
    plane_normals[1, PARAMETER] = 1.0
    guess = np.array([*state, period, line.value]) / curve.scales
    return curve, curve.orbits.solve(guess, plane_normals)


def hopf_event(system: System, hopf: HopfPoint) -> BranchEvent:
    """A Hopf point as an event of a branch."""
    y = equilibrium(system).y
    period = 2.0 * math.pi / hopf.omega
    return BranchEvent(EventKind.HOPF, hopf.value, period, y, y, hopf.direction)


def end_events(line: ParameterLine, value: float) -> list[BranchEvent]:
    """The event at the Hopf point in which a branch ends; none if it is out of range."""
    values = hopf_values(line.system, line.name, *line.bounds)
    if not values:
        return []
    system = line.with_value(min(values, key=lambda hopf: abs(hopf - value))).system
    return [hopf_event(system, hopf_point(system, line.name))]

"""Where branches of limit cycles begin, and what is found from there."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.model import (
    ComputationError,
    InputError,
    Parameters,
    State,
    accelerations,
    equilibrium,
    mode_of,
)
from fivtui.orbits.explorer import Explorer, Watch, starts_around
from fivtui.orbits.shooting import PeriodicOrbit

from .arclength import PERIOD, VALUE, FloatArray, OrbitCurve, OrbitOnCurve
from .following import MOST_POINTS, End, EventKind, Followed, Follower
from .hopf import HopfPoint, hopf_point, hopf_values
from .result import BranchEvent, CyclePoint

# Amplitude at a Hopf point, relative to the static deflection; a branch has returned at less.
_FIRST: Final = 5e-3
_RETURNED: Final = 4e-3

Begun = tuple[tuple[CyclePoint, ...], tuple[BranchEvent, ...], tuple[End, End]]


def from_hopf(
    p: Parameters, name: str, bounds: tuple[float, float], watch: Watch, *, separation: bool
) -> Begun:
    """The branch from the Hopf point nearest to the parameter set, with its events and ends."""
    if p.c1 == 0.0 and p.c2 == 0.0 and name not in ("c1", "c2"):
        raise ComputationError("without damping there is no Hopf point", "set c1 or c2 above 0")
    values = hopf_values(p, name, *bounds, separation=separation)
    if not values:
        raise ComputationError(
            f"no Hopf point with {name} from {bounds[0]:g} to {bounds[1]:g}",
            "widen the range, or begin at a limit cycle (--from cycle)",
        )
    value = min(values, key=lambda one: abs(one - getattr(p, name)))
    at = p.with_values({name: value})
    hopf = hopf_point(at, name, separation=separation)
    point = equilibrium(at, separation=separation)
    period = 2.0 * math.pi / hopf.omega
    if point.y == 0.0 and separation:
        raise ComputationError(
            f"the equilibrium is at y = 0 at the Hopf point {name} = {value:g}", "change F"
        )
    length = abs(point.y) or math.sqrt(at.k2 / at.k_nl)
    curve, follower = _follower(at, name, (bounds, length, period), watch, separation=separation)
    first = np.zeros(6)
    first[:4] = hopf.vector.real / curve.scales[:4] * length
    size = float(np.linalg.norm(first))
    rest = np.array([point.x, 0.0, point.y, 0.0, period, value]) / curve.scales
    across = np.zeros(6)
    across[:4] = (1j * hopf.vector).real / curve.scales[:4]
    start = curve.solve(rest + _FIRST / size * first, across / np.linalg.norm(across), first / size)
    if start is None:
        raise ComputationError(
            f"no limit cycle was found next to the Hopf point {name} = {value:g}",
            "begin at a limit cycle (--from cycle)",
        )
    found = follower.follow(start)
    points, events = _told(curve, start, found)
    events = [_hopf_event(at, hopf, separation=separation), *events]
    if found.end is End.EQUILIBRIUM:
        events += _last_hopf(p, name, points[-1], values, separation=separation)
    return tuple(points), tuple(events), (End.EQUILIBRIUM, found.end)


def from_cycle(
    p: Parameters, name: str, bounds: tuple[float, float], watch: Watch, *, separation: bool
) -> Begun:
    """The branch through the first limit cycle that transients reach, followed both ways."""
    if not bounds[0] <= getattr(p, name) <= bounds[1]:
        raise InputError(
            f"{name} = {getattr(p, name):g}: must be in the range {bounds[0]:g} to {bounds[1]:g}"
        )
    explorer = Explorer(p, separation=separation, go_on=watch.go_on)
    orbit = _first_cycle(p, explorer, separation=separation)
    return through(p, name, bounds, watch, (orbit.start, orbit.period), separation=separation)


def through(
    p: Parameters,
    name: str,
    bounds: tuple[float, float],
    watch: Watch,
    cycle: tuple[State, float],
    *,
    separation: bool,
) -> Begun:
    """The branch through a limit cycle, given by a state and its period, followed both ways."""
    state, period = cycle
    length = Explorer(p, separation=separation).length
    curve, follower = _follower(p, name, (bounds, length, period), watch, separation=separation)
    guess = np.array([*state, period, getattr(p, name)]) / curve.scales
    across = across_motion(p, state, curve.scales, separation=separation)
    start = curve.solve(guess, across, np.eye(6)[VALUE])
    if start is None:
        raise ComputationError(
            f"the limit cycle at {name} = {getattr(p, name):g} cannot be followed",
            "begin at another value, or at a Hopf point (--from hopf)",
        )
    up = follower.follow(start)
    points, events = _told(curve, start, up)
    if up.end is End.CLOSED:
        return tuple(points), tuple(events), (up.end, up.end)
    backwards = replace(start, tangent=-start.tangent, determinant=-start.determinant)
    down = follower.follow(backwards)
    before, events_before = _told(curve, start, down)
    points, events = [*before[:0:-1], *points], [*events_before[::-1], *events]
    values = hopf_values(p, name, *bounds, separation=separation)
    if down.end is End.EQUILIBRIUM:
        events = [*_last_hopf(p, name, points[0], values, separation=separation), *events]
    if up.end is End.EQUILIBRIUM:
        events += _last_hopf(p, name, points[-1], values, separation=separation)
    return tuple(points), tuple(events), (down.end, up.end)


def across_motion(
    p: Parameters, state: State, scales: FloatArray, *, separation: bool
) -> FloatArray:
    """Normal of the plane across the motion at a state, in scaled unknowns."""
    ax, ay = accelerations(p, state, mode_of(p, state, separation=separation))
    across = np.zeros(6)
    across[:4] = np.array([state[1], ax, state[3], ay]) / scales[:4]
    normal: FloatArray = across / np.linalg.norm(across)
    return normal


def _first_cycle(p: Parameters, explorer: Explorer, *, separation: bool) -> PeriodicOrbit:
    starts = starts_around(explorer, p, separation=separation)
    for start in starts:
        orbit = explorer.reach(start).orbit
        if orbit is not None:
            return orbit
    raise ComputationError(
        f"no limit cycle was found from {len(starts)} starts",
        "begin at another value, or at a Hopf point (--from hopf)",
    )


def scaled_curve(
    p: Parameters,
    name: str,
    measures: tuple[tuple[float, float], float, float],
    watch: Watch,
    *,
    separation: bool,
) -> OrbitCurve:
    """The equations of periodic orbits, scaled by the parameter's range, a length and a period."""
    (low, high), length, period = measures
    speed = 2.0 * math.pi * length / period
    # A power of two scales without rounding.
    value = 2.0 ** math.floor(math.log2(max(abs(getattr(p, name)), (high - low) / 64.0)))
    scales = np.array([length, speed, length, speed, period, value])
    return OrbitCurve(p, name, scales, separation=separation, go_on=watch.go_on)


def _follower(
    p: Parameters,
    name: str,
    measures: tuple[tuple[float, float], float, float],
    watch: Watch,
    *,
    separation: bool,
) -> tuple[OrbitCurve, Follower]:
    low, high = measures[0]
    curve = scaled_curve(p, name, measures, watch, separation=separation)
    value = float(curve.scales[VALUE])
    follower = Follower(
        curve,
        low / value,
        high / value,
        _RETURNED,
        lambda count: watch.tell(count / MOST_POINTS),
        touches=separation,
    )
    return curve, follower


def _told(
    curve: OrbitCurve, start: OrbitOnCurve, found: Followed
) -> tuple[list[CyclePoint], list[BranchEvent]]:
    points = [point_of(curve, orbit) for orbit in (start, *found.orbits)]
    events = [
        BranchEvent(kind, one.value, one.period, one.y_min, one.y_max)
        for place, kind in found.events.items()
        for one in [points[place + 1]]
    ]
    return points, events


def point_of(curve: OrbitCurve, orbit: OrbitOnCurve) -> CyclePoint:
    """An orbit of a curve as a limit cycle."""
    unknowns: FloatArray = orbit.unknowns * curve.scales
    x, vx, y, vy = unknowns[:4].tolist()
    multipliers = orbit.multipliers
    return CyclePoint(
        value=float(unknowns[VALUE]),
        period=float(unknowns[PERIOD]),
        start=(x, vx, y, vy),
        y_min=float(orbit.flow.extremes[2]),
        y_max=float(orbit.flow.extremes[3]),
        stable=bool(np.abs(multipliers).max() < 1.0),
        multipliers=tuple(multipliers.tolist()),
    )


def _hopf_event(p: Parameters, hopf: HopfPoint, *, separation: bool) -> BranchEvent:
    y = equilibrium(p, separation=separation).y
    period = 2.0 * math.pi / hopf.omega
    return BranchEvent(EventKind.HOPF, hopf.value, period, y, y, hopf.direction)


def _last_hopf(
    p: Parameters, name: str, last: CyclePoint, values: list[float], *, separation: bool
) -> list[BranchEvent]:
    # The Hopf point to which a branch has returned; none if it is beyond the range.
    if not values:
        return []
    value = min(values, key=lambda one: abs(one - last.value))
    at = p.with_values({name: value})
    return [_hopf_event(at, hopf_point(at, name, separation=separation), separation=separation)]

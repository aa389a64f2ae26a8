"""Branches of limit cycles along a parameter, stable and unstable.

A `ParameterLine` is the parameter that varies, with its system and range; a `BranchCurve` has the
equations of the cycles along it.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, Literal

import numpy as np

from fivtui.model import (
    ComputationError,
    InputError,
    OnProgress,
    Parameters,
    Progress,
    State,
    System,
    check_varied_are_used,
    parameter_spec,
    system_of,
)

from .arclength import PARAMETER, OrbitOnCurve
from .branch_curve import BranchCurve, ParameterLine
from .doubling import doubled_cycle, has_half_period, locate_doubling
from .events import MAX_POINTS, End, EventKind
from .files import interpolate_cycle, read_cycle
from .following import CurvePart, Follower, follow_both_ways
from .origins import BranchStart, attractor_start, cycle_near, cycle_start, end_events, hopf_start
from .result import BranchEvent, CycleBranch, CyclePoint, Origin

_ORIGINS: Final = ("hopf", "cycle")
# By default a parameter's range is from its value divided by this to its value times this.
_RANGE_FACTOR: Final = 10.0
# Amplitude below which a branch ends in the equilibrium, relative to the unit of length of the
# curve: the static deflection, or a larger characteristic length of the contact spring.
_MIN_AMPLITUDE: Final = 4e-3


def branch(
    parameters: Parameters | None,
    name: str,
    *,
    low: float | None = None,
    high: float | None = None,
    origin: Literal["hopf", "cycle"] | Path = "hopf",
    doubled: bool = False,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> CycleBranch:
    """Follow a branch of limit cycles along a parameter, through folds, stable or not.

    The method is pseudo-arclength continuation over shooting. Folds, the first touch of y = 0,
    period doublings and tori are located to 1e-10 of the parameter. On a belt of finite speed so is
    where a cycle begins or ceases to stick, or to be faster than the belt. Branches without
    connection to the first one are missed.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None. The branch begins at the Hopf point in the range
        that is nearest to the set's value of the parameter that varies.
    name : str
        The parameter that varies.
    low, high : float, optional
        Range of the parameter; a tenth and ten times its value if not given.
    origin : "hopf", "cycle" or Path
        The branch begins at a Hopf point of the equilibrium, or at the first limit cycle that
        transients of the parameter set reach. A path is a file, of a branch or of attractors as
        JSON, with a cycle of the set. From a cycle the branch is followed both ways.
    doubled : bool
        Whether to follow instead the branch of twice the period from its first period doubling.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the number of points relative to its limit; cancels the work by returning
        False.

    Returns
    -------
    CycleBranch
        The limit cycles along the branch, and the events.

    Raises
    ------
    InputError
        If the name is unknown, or the range is wrong.
    ComputationError
        If the range has no Hopf point or limit cycle to begin at.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import branch
    >>> result = branch(None, "mu", low=0.2, high=1.0)
    >>> [(str(event.kind), round(event.value, 6)) for event in result.events]
    [('hopf', 0.439388), ('touch', 0.37073), ('fold', 0.277877)]
    """
    system = system_of(parameters, separation)
    p = system.parameters
    if origin not in _ORIGINS and not isinstance(origin, Path):
        raise InputError(f"origin = {origin!r}: must be one of {', '.join(_ORIGINS)}, or a path")
    # A doubled branch may end in a crossing of branches, which is not located on belts of finite
    # speed. A belt whose speed is none is always faster than the slider.
    if doubled and p.v_belt is not None:
        raise InputError(
            f"v_belt = {p.v_belt:g}: must be none for branches of twice the period; to follow an "
            "attracting cycle of twice the period begin at it (--from cycle)"
        )
    lower, upper = parameter_range(p, name, low, high)
    least_speed = lower if name == "v_belt" else p.v_belt or 0.0
    if least_speed < 0.0:
        raise InputError(
            f"v_belt = {least_speed:g}: must not be negative for branches; follow attractors along "
            f"{name} instead"
        )
    if not separation and p.k_nl == 0.0 and name != "k_nl":
        raise InputError("k_nl = 0: must be above 0 if separation is ignored: motion is linear")
    line = ParameterLine(system, name, (lower, upper), Progress(progress))
    if isinstance(origin, Path):
        start = cycle_start(line, read_cycle(origin, system))
    elif origin == "hopf":
        start = hopf_start(line)
    else:
        start = attractor_start(line)
    origin_kind: Origin = "file" if isinstance(origin, Path) else origin
    cycles = (_follow_doubled if doubled else _follow_branch)(line, start, origin_kind)
    line.work.advance(1.0)
    return cycles


def branch_through(
    system: System,
    name: str,
    cycle: tuple[State, float],
    bounds: tuple[float, float],
    *,
    progress: OnProgress | None = None,
) -> CycleBranch:
    """The branch through a limit cycle of a system, followed both ways."""
    line = ParameterLine(system, name, bounds, Progress(progress))
    return _follow_branch(line, cycle_start(line, cycle), "cycle")


def _follow_branch(line: ParameterLine, start: BranchStart, origin: Origin) -> CycleBranch:
    # The branch is followed one way from a Hopf point, and both ways from a cycle.
    curve, hopf = start.curve, start.hopf
    end_at_start = None if hopf is None else End.EQUILIBRIUM
    cycles = follow_both_ways(_follower(curve, line.work).follow, start.orbit, end_at_start)
    points, events = _points_and_events(curve, cycles.points, cycles.events)
    first_end, final_end = cycles.ends
    if hopf is not None:
        events.insert(0, hopf)
    elif first_end is End.EQUILIBRIUM:
        events[:0] = end_events(line, points[0].value)
    if final_end is End.EQUILIBRIUM:
        events += end_events(line, points[-1].value)
    low, high = line.bounds
    return CycleBranch(
        line.system, line.name, low, high, origin, tuple(points), tuple(events), cycles.ends
    )


def _follow_doubled(line: ParameterLine, start: BranchStart, origin: Origin) -> CycleBranch:
    # The branch of twice the period, which may end on the branch of the single period.
    curve, first = start.curve, start.orbit
    follower = _follower(curve, line.work)
    doubling = EventKind.PERIOD_DOUBLING
    if start.hopf is None:
        doublings = follower.events_both_ways(first, doubling)
    else:
        # Behind the first cycle is the Hopf point: follow the branch one way, to a period doubling.
        ahead = follower.follow(first, until=(doubling,))
        doublings = [ahead.points[-1]] if ahead.end is End.EVENT else []
    if not doublings:
        raise ComputationError(
            f"no period doubling was found along {line.name}",
            "widen the range, or begin elsewhere",
        )
    nearest = min(
        doublings, key=lambda orbit: abs(orbit.unknowns[PARAMETER] - first.unknowns[PARAMETER])
    )
    (begin_point,) = cycle_points(curve, [nearest])
    cycle = doubled_cycle(curve, nearest)
    if cycle is None:
        raise ComputationError(
            f"no cycle of twice the period was found next to {line.name} = {begin_point.value:.9g}",
            "begin at one that transients reach (--from cycle)",
        )
    part = _follow_to_single_period(curve, follower, cycle)
    event_kinds = {index + 1: kind for index, kind in part.events.items()}
    points, events = _points_and_events(curve, (cycle, *part.points), event_kinds)
    events.insert(0, _event(doubling, begin_point))
    if part.end is End.DOUBLING:
        end_doubling = locate_doubling(curve, part.points[-1])
        if end_doubling is not None:
            events.append(_event(doubling, *cycle_points(curve, [end_doubling])))
    low, high = line.bounds
    return CycleBranch(
        line.system,
        line.name,
        low,
        high,
        origin,
        tuple(points),
        tuple(events),
        (End.DOUBLING, part.end),
        doubled=True,
    )


def _follow_to_single_period(
    curve: BranchCurve, follower: Follower[OrbitOnCurve], start: OrbitOnCurve
) -> CurvePart[OrbitOnCurve]:
    # Follow a branch of twice the period to its end, or to the branch of the single period.
    points: list[OrbitOnCurve] = []
    events: dict[int, EventKind] = {}
    start_event: EventKind | None = None
    while True:
        orbit, step = start, None
        # Beyond an event that was not the end, follow on with half of the last step.
        if len(points) > 1:
            orbit, previous = points[-1], points[-2]
            step = 0.5 * float(np.linalg.norm(orbit.unknowns - previous.unknowns))
        # The doubled branch turns back where it meets the branch of the single period. This end is
        # located as a fold or a crossing of branches, at which the cycle has half the period.
        part = follower.follow(
            orbit, step=step, until=(EventKind.BRANCH, EventKind.FOLD), start_event=start_event
        )
        events |= {len(points) + index: kind for index, kind in part.events.items()}
        points += part.points
        end = part.end
        if end is End.EVENT and has_half_period(curve, points[-1]):
            end = End.DOUBLING
            del events[len(points) - 1]
        if end is End.EVENT and len(points) >= MAX_POINTS:
            end = End.TOO_LONG
        if end is not End.EVENT:
            return CurvePart(tuple(points), events, end)
        start_event = events[len(points) - 1]


def _follower(curve: BranchCurve, work: Progress) -> Follower[OrbitOnCurve]:
    # A follower that reports the number of points, relative to its limit.
    return Follower(curve, _MIN_AMPLITUDE, lambda count: work.report(count / MAX_POINTS))


def cycle_points(curve: BranchCurve, orbits: Sequence[OrbitOnCurve]) -> list[CyclePoint]:
    """The limit cycles of orbits on a curve, with their stability."""
    unknowns = (np.array([orbit.unknowns for orbit in orbits]) * curve.scales).tolist()
    # By falling size, without the one along the orbit, which is 1: the first decides stability.
    multipliers = curve.multipliers(orbits)
    stabilities = (np.abs(multipliers[:, 0]) < 1.0).tolist()
    return [
        CyclePoint(value, period, (x, vx, y, vy), orbit.y_min, orbit.y_max, stable, tuple(row))
        for orbit, (x, vx, y, vy, period, value), stable, row in zip(
            orbits, unknowns, stabilities, multipliers.tolist(), strict=True
        )
    ]


def _points_and_events(
    curve: BranchCurve, orbits: Sequence[OrbitOnCurve], events: Mapping[int, EventKind]
) -> tuple[list[CyclePoint], list[BranchEvent]]:
    points = cycle_points(curve, orbits)
    return points, [_event(kind, points[index]) for index, kind in events.items()]


def _event(kind: EventKind, point: CyclePoint) -> BranchEvent:
    return BranchEvent(kind, point.value, point.period, point.y_min, point.y_max)


def cycles_at(
    branch: CycleBranch, value: float, *, progress: OnProgress | None = None
) -> tuple[CyclePoint, ...]:
    """The limit cycles of a branch at a value of its parameter, in the order of the branch."""
    line = ParameterLine(
        branch.system, branch.name, (branch.low, branch.high), Progress(progress)
    ).with_value(value)
    cycles: list[CyclePoint] = []
    for guess in _cycles_near(branch.points, value):
        curve, orbit = cycle_near(line, guess)
        if orbit is not None:
            cycles += cycle_points(curve, [orbit])
    return tuple(cycles)


def _cycles_near(points: Sequence[CyclePoint], value: float) -> Iterator[tuple[State, float]]:
    # State and period of each cycle exactly at a value of the parameter; where the value is
    # strictly between two points, of the cycle interpolated between them.
    previous: CyclePoint | None = None
    for point in points:
        if point.value == value:
            yield point.start, point.period
        elif previous is not None and (
            previous.value < value < point.value or previous.value > value > point.value
        ):
            begin, end = ((p.value, p.start, p.period) for p in (previous, point))
            yield interpolate_cycle(begin, end, value)
        previous = point


def parameter_range(
    p: Parameters, name: str, low: float | None, high: float | None
) -> tuple[float, float]:
    """A checked range of a parameter; by default a tenth and ten times its value.

    Raises `InputError` if the range is wrong, or the parameter has no value or no effect on motion.
    """
    spec, value = parameter_spec(name), getattr(p, name)
    # Optional parameters describe a belt of finite speed. Without v_belt it is always faster than
    # the slider, and they have no effect.
    if value is None or (spec.optional and p.v_belt is None):
        missing = name if value is None else "v_belt"
        raise InputError(f"{missing} = none: must have a value to vary {name}")
    check_varied_are_used(p, (name,))
    if (low is None or high is None) and not value > 0.0:
        raise InputError(f"{name} = {value:g}: must be above 0 unless the range is given")
    lower = max(value / _RANGE_FACTOR, spec.lower) if low is None else spec.check(low)
    upper = min(value * _RANGE_FACTOR, spec.upper) if high is None else spec.check(high)
    # Friction falls from μ_s to μ.
    if name == "mu" and p.mu_s is not None:
        upper = min(upper, p.mu_s) if high is None else upper
        if upper > p.mu_s:
            raise InputError(f"mu: {lower:g} to {upper:g}: must be at most mu_s = {p.mu_s:g}")
    if name == "mu_s":
        lower = max(lower, p.mu) if low is None else lower
        if lower < p.mu:
            raise InputError(f"mu_s: {lower:g} to {upper:g}: must be at least mu = {p.mu:g}")
    if not lower < upper:
        raise InputError(f"{name}: {lower:g} to {upper:g}: must be a range of ascending values")
    return lower, upper

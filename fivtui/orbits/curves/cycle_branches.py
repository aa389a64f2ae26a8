"""Branches of limit cycles along a parameter, stable and unstable."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
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
    check_effect,
    parameter_spec,
    system_of,
)

from .arclength import VALUE, OrbitOnCurve
from .branch_curve import BranchCurve, ParameterLine
from .doubling import doubled_cycle, doubling_near, halves
from .events import MOST_POINTS, End, EventKind
from .following import Followed, Follower, follow_both_ways
from .origins import Beginning, cycle_near, from_cycle, from_hopf, nearest_hopf, through
from .result import BranchEvent, CycleBranch, CyclePoint, Origin
from .saved import interpolated, saved_cycle

_ORIGINS: Final = ("hopf", "cycle")
# Default range of the parameter: its value over and times this.
_SPAN: Final = 10.0
# Amplitude, relative to the characteristic length, below which a branch ends in the equilibrium.
_RETURNED: Final = 4e-3


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
    period doublings and tori are located to 1e-10 of the parameter. On a belt of finite speed so
    are points where a cycle begins or ceases to stick or to be faster than the belt. Branches
    without connection to the first one are missed.

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
        Where the branch begins: at a Hopf point of the equilibrium, at the first limit cycle that
        transients of the parameter set reach, or at the first cycle of the set in a file (a branch,
        or attractors as JSON). From a cycle the branch is followed both ways.
    doubled : bool
        Whether to follow instead the branch of twice the period from its first period doubling.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction of the greatest number of points; cancels the work by returning
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
        If there is nothing to begin with in the range.
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
    if doubled and p.v_belt is not None:
        raise InputError(
            f"v_belt = {p.v_belt:g}: must be none for branches of twice the period; one that "
            "attracts is followed by --from cycle"
        )
    bottom, top = parameter_range(p, name, low, high)
    if not separation and p.k_nl == 0.0 and name != "k_nl":
        raise InputError("k_nl = 0: must be above 0 where separation is ignored: it is linear")
    line = ParameterLine(system, name, (bottom, top), Progress(progress))
    if isinstance(origin, Path):
        beginning = through(line, saved_cycle(origin, system))
    elif origin == "hopf":
        beginning = from_hopf(line)
    else:
        beginning = from_cycle(line)
    begins_at: Origin = "file" if isinstance(origin, Path) else origin
    cycles = (_follow_doubled if doubled else _follow_branch)(line, beginning, begins_at)
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
    return _follow_branch(line, through(line, cycle), "cycle")


def _follow_branch(line: ParameterLine, beginning: Beginning, origin: Origin) -> CycleBranch:
    # The branch followed both ways, or away from a Hopf point.
    curve, hopf = beginning.curve, beginning.hopf
    begins = None if hopf is None else End.EQUILIBRIUM
    both = follow_both_ways(_follower(curve, line.work).follow, beginning.start, begins)
    points, events = _results(curve, both.points, both.events)
    begin, end = both.ends
    if hopf is not None:
        events.insert(0, hopf)
    elif begin is End.EQUILIBRIUM:
        events[:0] = nearest_hopf(line, points[0].value)
    if end is End.EQUILIBRIUM:
        events += nearest_hopf(line, points[-1].value)
    low, high = line.bounds
    return CycleBranch(
        line.system, line.name, low, high, origin, tuple(points), tuple(events), both.ends
    )


def _follow_doubled(line: ParameterLine, beginning: Beginning, origin: Origin) -> CycleBranch:
    # The doubled branch up to its end on the branch of the single period, or any other end.
    curve, start = beginning.curve, beginning.start
    follower = _follower(curve, line.work)
    doubling = EventKind.PERIOD_DOUBLING
    if beginning.hopf is None:
        doublings = follower.events_both_ways(start, doubling)
    else:
        ahead = follower.follow(start, until=(doubling,))
        doublings = [ahead.points[-1]] if ahead.end is End.EVENT else []
    if not doublings:
        raise ComputationError(
            f"no period doubling was found along {line.name}",
            "widen the range, or begin elsewhere",
        )
    nearest = min(doublings, key=lambda orbit: abs(orbit.unknowns[VALUE] - start.unknowns[VALUE]))
    (first,) = points_of(curve, [nearest])
    cycle = doubled_cycle(curve, nearest)
    if cycle is None:
        raise ComputationError(
            f"no cycle of twice the period was found next to {line.name} = {first.value:.9g}",
            "begin at one that transients reach (--from cycle)",
        )
    part = _until_halved(curve, follower, cycle)
    shifted = {index + 1: kind for index, kind in part.events.items()}
    points, events = _results(curve, (cycle, *part.points), shifted)
    events.insert(0, _event(doubling, first))
    if part.end is End.DOUBLING:
        end = doubling_near(curve, part.points[-1])
        if end is not None:
            events.append(_event(doubling, *points_of(curve, [end])))
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


def _until_halved(
    curve: BranchCurve, follower: Follower[OrbitOnCurve], start: OrbitOnCurve
) -> Followed[OrbitOnCurve]:
    points: list[OrbitOnCurve] = []
    events: dict[int, EventKind] = {}
    at: EventKind | None = None
    while True:
        orbit, step = start, None
        if len(points) > 1:
            orbit, before = points[-1], points[-2]
            step = 0.5 * float(np.linalg.norm(orbit.unknowns - before.unknowns))
        # At the end on the single period the branch turns back on itself.
        part = follower.follow(orbit, step=step, until=(EventKind.BRANCH, EventKind.FOLD), at=at)
        events |= {len(points) + index: kind for index, kind in part.events.items()}
        points += part.points
        end = part.end
        if end is End.EVENT and halves(curve, points[-1]):
            end = End.DOUBLING
            del events[len(points) - 1]
        if end is End.EVENT and len(points) >= MOST_POINTS:
            end = End.LONG
        if end is not End.EVENT:
            return Followed(tuple(points), events, end)
        at = events[len(points) - 1]


def _follower(curve: BranchCurve, work: Progress) -> Follower[OrbitOnCurve]:
    return Follower(curve, _RETURNED, lambda count: work.report(count / MOST_POINTS))


def points_of(curve: BranchCurve, orbits: Sequence[OrbitOnCurve]) -> list[CyclePoint]:
    """Orbits of a curve as limit cycles."""
    multipliers = curve.multipliers(orbits)
    unknowns = (np.array([orbit.unknowns for orbit in orbits]) * curve.scales).tolist()
    extremes = np.array([orbit.extremes for orbit in orbits]).tolist()
    stable = (np.abs(multipliers[:, 0]) < 1.0).tolist()
    return [
        CyclePoint(value, period, (x, vx, y, vy), low, high, steady, tuple(values))
        for (x, vx, y, vy, period, value), (_, _, low, high, *_), steady, values in zip(
            unknowns, extremes, stable, multipliers.tolist(), strict=True
        )
    ]


def _results(
    curve: BranchCurve, orbits: Sequence[OrbitOnCurve], events: Mapping[int, EventKind]
) -> tuple[list[CyclePoint], list[BranchEvent]]:
    points = points_of(curve, orbits)
    return points, [_event(kind, points[index]) for index, kind in events.items()]


def _event(kind: EventKind, point: CyclePoint) -> BranchEvent:
    return BranchEvent(kind, point.value, point.period, point.y_min, point.y_max)


def cycles_at(
    branch: CycleBranch, value: float, *, progress: OnProgress | None = None
) -> tuple[CyclePoint, ...]:
    """The limit cycles of a branch at a value of its parameter, in the order of the branch."""
    cycles: list[CyclePoint] = []
    line = ParameterLine(
        branch.system, branch.name, (branch.low, branch.high), Progress(progress)
    ).at(value)
    for begin, end in pairwise(branch.points):
        passed = (begin.value - value) * (end.value - value) <= 0.0
        # A point exactly at the value is in two pairs: count it once.
        if passed and begin.value not in (end.value, value):
            values = ((point.value, point.start, point.period) for point in (begin, end))
            cycle = interpolated(next(values), next(values), value)
            curve, orbit = cycle_near(line, cycle)
            if orbit is not None:
                cycles += points_of(curve, [orbit])
    return tuple(cycles)


def parameter_range(
    p: Parameters, name: str, low: float | None, high: float | None
) -> tuple[float, float]:
    """A checked range of a parameter; by default a tenth and ten times its value."""
    spec, value = parameter_spec(name), getattr(p, name)
    if value is None or (spec.optional and p.v_belt is None):
        missing = name if value is None else "v_belt"
        raise InputError(f"{missing} = none: must have a value to vary {name}")
    check_effect(p, (name,))
    if (low is None or high is None) and not value > 0.0:
        raise InputError(f"{name} = {value:g}: must be above 0, or the range be given")
    bottom = max(value / _SPAN, spec.lower) if low is None else spec.check(low)
    top = min(value * _SPAN, spec.upper) if high is None else spec.check(high)
    # Friction falls from μ_s to μ.
    if name == "mu" and p.mu_s is not None:
        top = min(top, p.mu_s) if high is None else top
        if top > p.mu_s:
            raise InputError(f"mu: {bottom:g} to {top:g}: must be at most mu_s = {p.mu_s:g}")
    if name == "mu_s":
        bottom = max(bottom, p.mu) if low is None else bottom
        if bottom < p.mu:
            raise InputError(f"mu_s: {bottom:g} to {top:g}: must be at least mu = {p.mu:g}")
    if not bottom < top:
        raise InputError(f"{name}: {bottom:g} to {top:g}: must be a range of ascending values")
    return bottom, top

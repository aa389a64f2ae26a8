"""Branches of limit cycles along a parameter, stable and unstable."""

from collections.abc import Sequence
from dataclasses import replace
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
from .branch_curve import BranchCurve
from .doubling import doubled_cycle, doubling_near, halves
from .events import MOST_POINTS, End, EventKind, makeup
from .following import Followed, Follower
from .origins import Beginning, from_cycle, from_hopf, nearest_hopf, through
from .result import BranchEvent, CycleBranch, CyclePoint, Origin
from .saved import saved_cycle

_ORIGINS: Final = ("hopf", "cycle")
# Bounds of the parameter, if not given: its value over and times this.
_SPAN: Final = 10.0
# Amplitude relative to the characteristic length at which a branch has returned to the equilibrium.
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

    By pseudo-arclength continuation over shooting: folds, the first touch of y = 0, period
    doublings and tori are located to 1e-10 of the parameter; on a belt of finite speed also where a
    cycle begins or ceases to stick or to be faster than the belt. Branches that are not connected
    to the one followed are not found.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None. Of several Hopf points in the range the one
        nearest to its value of the parameter that varies is taken.
    name : str
        The parameter that varies.
    low, high : float, optional
        Range of the parameter; a tenth and ten times its value if not given.
    origin : "hopf", "cycle" or Path
        Where the branch begins: at a Hopf point of the equilibrium, at the first limit cycle that
        is reached by transients of the parameter set, or at the first one of the set in a file: a
        branch, or attractors as JSON. From a cycle it is followed both ways.
    doubled : bool
        Whether to follow the branch of twice the period that begins at its first period doubling
        instead.
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
    >>> found = branch(None, "mu", low=0.2, high=1.0)
    >>> [(str(event.kind), round(event.value, 6)) for event in found.events]
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
    work = Progress(progress)
    given = (system, name, (bottom, top), work)
    if isinstance(origin, Path):
        beginning = through(*given, saved_cycle(origin, system))
    elif origin == "hopf":
        beginning = from_hopf(*given)
    else:
        beginning = from_cycle(*given)
    if doubled:
        points, events, ends = _doubled(name, work, beginning)
    else:
        points, events, ends = _followed(*given, beginning)
    work.advance(1.0)
    told: Origin = "file" if isinstance(origin, Path) else origin
    return CycleBranch(system, name, bottom, top, told, points, events, ends, doubled)


def branch_through(
    system: System,
    name: str,
    cycle: tuple[State, float],
    bounds: tuple[float, float],
    *,
    progress: OnProgress | None = None,
) -> CycleBranch:
    """The branch through a limit cycle of a system, followed both ways."""
    work = Progress(progress)
    beginning = through(system, name, bounds, work, cycle)
    parts = _followed(system, name, bounds, work, beginning)
    low, high = bounds
    return CycleBranch(system, name, low, high, "cycle", *parts)


_Parts = tuple[tuple[CyclePoint, ...], tuple[BranchEvent, ...], tuple[End, End]]


def _followed(
    system: System,
    name: str,
    bounds: tuple[float, float],
    work: Progress,
    beginning: Beginning,
) -> _Parts:
    # Both ways, or away from a Hopf point.
    curve, start = beginning.curve, beginning.start
    follower = _follower(curve, work)
    ahead = follower.follow(start)
    points, events = _told(curve, start, ahead)
    ends = (End.EQUILIBRIUM if beginning.hopf is not None else ahead.end, ahead.end)
    if beginning.hopf is not None:
        events = [beginning.hopf, *events]
    elif ahead.end is not End.CLOSED:
        back = follower.follow(_turned(start))
        before, events_before = _told(curve, start, back)
        points, events = [*before[:0:-1], *points], [*events_before[::-1], *events]
        ends = (back.end, ahead.end)
        if back.end is End.EQUILIBRIUM:
            first = nearest_hopf(system, name, bounds, points[0].value)
            events = [*first, *events]
    if ahead.end is End.EQUILIBRIUM:
        events += nearest_hopf(system, name, bounds, points[-1].value)
    return tuple(points), tuple(events), ends


def _doubled(name: str, work: Progress, beginning: Beginning) -> _Parts:
    # As far as the branch meets that of half the period again, or ends.
    curve, start = beginning.curve, beginning.start
    follower = _follower(curve, work)
    ways = [start] if beginning.hopf is not None else [start, _turned(start)]
    parts = [follower.follow(one, until=EventKind.PERIOD_DOUBLING) for one in ways]
    met = [part.points[-1] for part in parts if part.end is End.EVENT]
    if not met:
        raise ComputationError(
            f"no period doubling was found along {name}", "widen the range, or begin elsewhere"
        )
    begin = min(met, key=lambda one: abs(one.unknowns[VALUE] - start.unknowns[VALUE]))
    (first,) = points_of(curve, [begin])
    cycle = doubled_cycle(curve, begin)
    if cycle is None:
        raise ComputationError(
            f"no cycle of twice the period was found next to {name} = {first.value:.9g}",
            "begin at one that transients reach (--from cycle)",
        )
    found = _until_halved(curve, follower, cycle)
    points, events = _told(curve, cycle, found)
    events = [_event(EventKind.PERIOD_DOUBLING, first), *events]
    if found.end is End.DOUBLING:
        last = doubling_near(curve, found.points[-1])
        if last is not None:
            events.append(_event(EventKind.PERIOD_DOUBLING, *points_of(curve, [last])))
    return tuple(points), tuple(events), (End.DOUBLING, found.end)


def _until_halved(
    curve: BranchCurve, follower: Follower[OrbitOnCurve], start: OrbitOnCurve
) -> Followed[OrbitOnCurve]:
    points: list[OrbitOnCurve] = []
    events: dict[int, EventKind] = {}
    at: EventKind | None = None
    while True:
        here, step = start, None
        if len(points) > 1:
            here, before = points[-1], points[-2]
            step = 0.5 * float(np.linalg.norm(here.unknowns - before.unknowns))
        # There the branch turns back on itself.
        part = follower.follow(here, step=step, until=(EventKind.BRANCH, EventKind.FOLD), at=at)
        events |= {len(points) + place: kind for place, kind in part.events.items()}
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
    return Follower(
        curve,
        _RETURNED,
        lambda count: work.report(count / MOST_POINTS),
        turns=True,
        courses=curve.courses,
    )


def _turned(start: OrbitOnCurve) -> OrbitOnCurve:
    return replace(start, tangent=-start.tangent, determinant=-start.determinant)


def points_of(curve: BranchCurve, orbits: Sequence[OrbitOnCurve]) -> list[CyclePoint]:
    """Orbits of a curve as limit cycles."""
    multipliers = np.linalg.eigvals(np.array([orbit.monodromy for orbit in orbits]))
    sizes = np.abs(multipliers)
    order = np.argsort(-sizes, axis=1, kind="stable")
    sorted_by_size = np.take_along_axis(multipliers.astype(np.complex128), order, axis=1)
    if curve.courses is not None:
        # A stick takes a deviation away, exactly.
        sorted_by_size[[makeup(orbit).sticks > 0.0 for orbit in orbits], -1] = 0.0
    chosen = sorted_by_size.tolist()
    unknowns = (np.array([orbit.unknowns for orbit in orbits]) * curve.scales).tolist()
    extremes = np.array([orbit.extremes for orbit in orbits]).tolist()
    stable = (sizes.max(axis=1) < 1.0).tolist()
    return [
        CyclePoint(value, period, (x, vx, y, vy), low, high, steady, tuple(each))
        for (x, vx, y, vy, period, value), (_, _, low, high, *_), steady, each in zip(
            unknowns, extremes, stable, chosen, strict=True
        )
    ]


def _told(
    curve: BranchCurve, start: OrbitOnCurve, found: Followed[OrbitOnCurve]
) -> tuple[list[CyclePoint], list[BranchEvent]]:
    points = points_of(curve, (start, *found.points))
    return points, [_event(kind, points[place + 1]) for place, kind in found.events.items()]


def _event(kind: EventKind, point: CyclePoint) -> BranchEvent:
    return BranchEvent(kind, point.value, point.period, point.y_min, point.y_max)


def parameter_range(
    p: Parameters, name: str, low: float | None, high: float | None
) -> tuple[float, float]:
    """A range of a parameter, checked; a tenth and ten times its value where not given."""
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

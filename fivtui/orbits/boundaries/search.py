"""Boundaries over two parameters: where their curves begin, and the curves."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Final, Protocol, TypeVar

import numpy as np

from fivtui.model import (
    ComputationError,
    InputError,
    OnProgress,
    Parameters,
    Progress,
    System,
    check_always_sliding,
    equilibrium,
    number_spec,
    system_of,
)
from fivtui.orbits.curves.arclength import OrbitOnCurve
from fivtui.orbits.curves.cycle_branches import branch, parameter_range
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Follower
from fivtui.orbits.curves.hopf import hopf_values
from fivtui.orbits.curves.result import CyclePoint
from fivtui.orbits.rest import length_scale

from .hopf_curve import HopfCurve, HopfOnCurve
from .plane import ParameterPlane
from .result import (
    BOUNDARIES,
    Boundary,
    BoundaryCurve,
    BoundaryEvent,
    BoundaryKind,
    BoundaryPoint,
)
from .touch_curve import TouchCurve, highest_point
from .tracing import FoldTracer, reversed_fold

# Values of one parameter, beside its own, at which branches along the other are looked at.
_LINES: Final = 8
# A point is on a curve that is nearer than this part of the distance between two of its points.
_NEAR: Final = 0.1
_SAME: Final = 1e-6
_LEAST: Final = 1e-100
# Steps along Hopf points within which a curve of folds that shrinks must begin, and the first one.
_MOST_TO_BAUTIN: Final = 40
_FIRST_STEP: Final = 1e-4


def boundary(
    parameters: Parameters | None,
    kind: BoundaryKind,
    over: Mapping[str, tuple[float, float] | None],
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> Boundary:
    """Follow the curves of Hopf points, folds or touches of limit cycles over two parameters.

    The curves begin at the events of branches that begin at Hopf points, at nine values of one of
    the parameters: others are not found. Cusps, where two curves of folds meet and end, and Hopf
    points at which folds begin (Bautin) are located on the way.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None.
    kind : "hopf", "fold" or "touch"
        What is on the curves: Hopf points of the equilibrium, limit cycles that turn back, or
        limit cycles whose highest point is at y = 0.
    over : mapping of str to tuple of float
        Lowest and highest value of two parameters; None for a tenth and ten times its value.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    Boundary
        The curves, with their events.

    Raises
    ------
    InputError
        If a name or range is wrong.
    ComputationError
        If there is no such point in the ranges.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, boundary
    >>> found = boundary(Parameters(F=30.0), "fold", {"F": (28.0, 40.0), "mu": (0.2, 0.6)})
    >>> [(str(event.kind), round(event.values[0], 6)) for event in found.events]
    [('cusp', 36.510164)]
    """
    plane = _plane(system_of(parameters, separation), kind, over)
    work = Progress(progress)
    curves: list[BoundaryCurve] = []
    trace = {"hopf": _hopf_curves, "fold": _fold_curves, "touch": _touch_curves}[kind]
    # What is found already is looked at while more is looked for.
    curves.extend(trace(plane, work, curves))
    work.advance(1.0)
    if not curves:
        names = " and ".join(plane.names)
        raise ComputationError(
            f"no {_SAID[kind]} was found over {names}", "widen the ranges, or change the others"
        )
    return Boundary(plane.system, kind, plane.names, plane.ranges, tuple(curves))


_SAID: Final = {"hopf": "Hopf point", "fold": "fold", "touch": "touch of y = 0"}


def _plane(
    system: System, kind: BoundaryKind, over: Mapping[str, tuple[float, float] | None]
) -> ParameterPlane:
    p, separation = system.parameters, system.separation
    check_always_sliding(p, "boundaries; follow branches over one parameter instead")
    if kind not in BOUNDARIES:
        raise InputError(f"kind = {kind!r}: must be one of {', '.join(BOUNDARIES)}")
    if len(over) != 2:
        raise InputError(f"over: {len(over)} parameters are given; must be two")
    if kind == "touch" and not separation:
        raise InputError("touch: separation must be considered")
    if not separation and p.k_nl == 0.0 and "k_nl" not in over and kind != "hopf":
        raise InputError("k_nl = 0: must be above 0 where separation is ignored: it is linear")
    ranges = []
    for name, ends in over.items():
        number_spec(name)
        ranges.append(parameter_range(p, name, *((None, None) if ends is None else ends)))
    first, second = over
    return ParameterPlane(system, (first, second), (ranges[0], ranges[1]))


def _lines(plane: ParameterPlane, work: Progress) -> Iterator[tuple[System, str, int]]:
    # Systems with values of one of the two, the name of the other, and its place: friction
    # if it is one of them, along which there is one Hopf point at most.
    along = 0 if plane.names[0] == "mu" else 1
    low, high = plane.ranges[1 - along]
    name = plane.names[1 - along]
    own = getattr(plane.system.parameters, name)
    values = [low + (high - low) * (place + 0.5) / _LINES for place in range(_LINES)]
    for count, value in enumerate([*([own] if low <= own <= high else []), *values]):
        work.report(count / (_LINES + 1))
        yield plane.system.with_values({name: value}), plane.names[along], along


def _events(
    plane: ParameterPlane, kind: EventKind, work: Progress
) -> Iterator[tuple[System, CyclePoint, FloatArray]]:
    # Cycles at events of branches, the systems, and the values of both parameters.
    for system, name, along in _lines(plane, work):
        p = system.parameters
        low, high = plane.ranges[along]
        try:
            found = branch(p, name, low=low, high=high, separation=system.separation)
        except ComputationError:
            continue
        places = {(event.value, event.period) for event in found.events if event.kind is kind}
        for point in found.points:
            if (point.value, point.period) in places:
                values = [getattr(p, each) for each in plane.names]
                values[along] = point.value
                yield system.with_values({name: point.value}), point, np.array(values)


def _fold_curves(
    plane: ParameterPlane, work: Progress, known: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    for system, cycle, values in _events(plane, EventKind.FOLD, work):
        if _is_on(plane, known, values, (cycle.period, cycle.y_min, cycle.y_max)):
            continue
        length = length_scale(system)
        tracer = FoldTracer(plane, length, cycle.period, lambda _count: None, work.go_on)
        unknowns = np.array([*cycle.start, cycle.period, *values]) / tracer.scales
        extremes = np.array([0.0, 0.0, cycle.y_min, cycle.y_max])
        none = np.zeros(0)
        start = tracer.begin(OrbitOnCurve(unknowns, none, none, none, extremes, 0.0, 0))
        if start is None:
            continue
        turned = reversed_fold(start)
        found = _both_ways(tracer.follow, start, turned, partial(_cycle_point, tracer.scales))
        yield _with_bautin(plane, found, work)


def _touch_curves(
    plane: ParameterPlane, work: Progress, known: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    for system, cycle, values in _events(plane, EventKind.TOUCH, work):
        if _is_on(plane, known, values, (cycle.period, cycle.y_min, cycle.y_max)):
            continue
        length = length_scale(system)
        curve = TouchCurve(plane, length, cycle.period, go_on=work.go_on)
        top = highest_point(plane, cycle.start, cycle.period, values)
        start = curve.begin(top, cycle.period, values)
        if start is None:
            continue
        turned = replace(start, tangent=-start.tangent, determinant=-start.determinant)
        follower = Follower(curve, 0.0, lambda _count: None)
        yield _both_ways(follower.follow, start, turned, partial(_cycle_point, curve.scales))


def _hopf_curves(
    plane: ParameterPlane, work: Progress, known: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    curve = HopfCurve(plane, go_on=work.go_on)
    follower = Follower(curve, 0.0, lambda _count: None)
    for system, name, along in _lines(plane, work):
        for value in hopf_values(system, name, *plane.ranges[along]):
            values = [getattr(system.parameters, each) for each in plane.names]
            values[along] = value
            start = curve.begin((values[0], values[1]), 1 - along)
            if start is None:
                continue
            here = _hopf_point(plane, curve.scales, start)
            at = start.unknowns * curve.scales
            if _is_on(plane, known, at, (here.period, here.y_min, here.y_max)):
                continue
            turned = replace(start, tangent=-start.tangent)
            yield _both_ways(
                follower.follow, start, turned, partial(_hopf_point, plane, curve.scales)
            )


P = TypeVar("P")
_P_co = TypeVar("_P_co", covariant=True)


class _Part(Protocol[_P_co]):
    # What is followed from a start in one direction: `Followed` or `FoldPart`.
    @property
    def points(self) -> Sequence[_P_co]: ...
    @property
    def events(self) -> Mapping[int, EventKind]: ...
    @property
    def end(self) -> End: ...


def _both_ways(
    follow: Callable[[P], _Part[P]], start: P, turned: P, told: Callable[[P], BoundaryPoint]
) -> BoundaryCurve:
    ahead = follow(start)
    ends, before = (ahead.end, ahead.end), 0
    points, events = [start, *ahead.points], dict(ahead.events)
    if ahead.end is not End.CLOSED:
        back = follow(turned)
        ends, before = (back.end, ahead.end), len(back.points)
        points = [*back.points[::-1], *points]
        events = {before + 1 + place: kind for place, kind in events.items()}
        events |= {before - 1 - place: kind for place, kind in back.events.items()}
    else:
        events = {1 + place: kind for place, kind in events.items()}
    shown = [told(point) for point in points]
    return BoundaryCurve(
        tuple(shown), tuple(_event(events[place], shown[place]) for place in sorted(events)), ends
    )


def _with_bautin(plane: ParameterPlane, curve: BoundaryCurve, work: Progress) -> BoundaryCurve:
    # Folds that shrink into the equilibrium end at a Hopf point whose Lyapunov coefficient is zero.
    points, events = curve.points, curve.events
    if curve.ends[0] is End.EQUILIBRIUM:
        found = _bautin(plane, points[0], work)
        points, events = (*found, *points), (*map(_bautin_event, found), *events)
    if curve.ends[1] is End.EQUILIBRIUM:
        found = _bautin(plane, points[-1], work)
        points, events = (*points, *found), (*events, *map(_bautin_event, found))
    return BoundaryCurve(points, events, curve.ends)


def _bautin(plane: ParameterPlane, near: BoundaryPoint, work: Progress) -> list[BoundaryPoint]:
    curve = HopfCurve(plane, go_on=work.go_on)
    along = 0 if plane.names[0] == "mu" else 1
    start = curve.begin(near.values, 1 - along)
    if start is None:
        return []
    follower = Follower(curve, 0.0, lambda _count: None, most=_MOST_TO_BAUTIN)
    found = []
    for one in (start, replace(start, tangent=-start.tangent)):
        part = follower.follow(one, step=_FIRST_STEP, until=EventKind.BAUTIN)
        if part.end is End.EVENT:
            last = part.points[-1]
            distance = float(np.linalg.norm(last.unknowns - start.unknowns))
            found.append((distance, _hopf_point(plane, curve.scales, last)))
    return [min(found, key=lambda one: one[0])[1]] if found else []


def _bautin_event(point: BoundaryPoint) -> BoundaryEvent:
    return _event(EventKind.BAUTIN, point)


def _event(kind: EventKind, point: BoundaryPoint) -> BoundaryEvent:
    return BoundaryEvent(kind, point.values, point.period, point.y_min, point.y_max)


def _cycle_point(scales: FloatArray, orbit: OrbitOnCurve) -> BoundaryPoint:
    x, vx, y, vy, period, first, second = (orbit.unknowns * scales).tolist()
    low, high = orbit.extremes[2:4].tolist()
    multipliers = tuple(orbit.multipliers.tolist())
    return BoundaryPoint((first, second), period, (x, vx, y, vy), low, high, multipliers)


def _hopf_point(plane: ParameterPlane, scales: FloatArray, point: HopfOnCurve) -> BoundaryPoint:
    first, second = (point.unknowns * scales).tolist()
    rest = equilibrium(plane.at((first, second)))
    return BoundaryPoint(
        (first, second),
        2.0 * math.pi / point.hopf.omega,
        (rest.x, 0.0, rest.y, 0.0),
        rest.y,
        rest.y,
        lyapunov=point.hopf.lyapunov,
    )


def _is_on(
    plane: ParameterPlane,
    known: Sequence[BoundaryCurve],
    values: FloatArray,
    measures: tuple[float, float, float],
) -> bool:
    # Whether a point is on a curve that is known, by its parameters, period and extremes.
    period, y_min, y_max = measures
    units = np.array([*plane.units, period, abs(y_min), abs(y_min)])
    here = np.array([*values, period, y_min, y_max]) / units
    for curve in known:
        passed = np.array([[*one.values, one.period, one.y_min, one.y_max] for one in curve.points])
        passed /= units
        ways = np.diff(passed, axis=0)
        lengths = np.maximum(np.linalg.norm(ways, axis=1), _LEAST)
        shares = np.clip(((here - passed[:-1]) * ways).sum(axis=1) / lengths**2, 0.0, 1.0)
        away = np.linalg.norm(passed[:-1] + shares[:, None] * ways - here, axis=1)
        if (away < _NEAR * lengths + _SAME).any():
            return True
    return False

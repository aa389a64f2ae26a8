"""Boundaries: curves over two parameters on which Hopf points, folds or touching cycles lie.

They begin at events on branches of limit cycles along one of the parameters.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import Final, TypeVar

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
from fivtui.orbits.curves.following import CurvePart, Follower, PointOnCurve, follow_both_ways
from fivtui.orbits.curves.hopf import hopf_values
from fivtui.orbits.curves.result import CyclePoint, event_at
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
from .touch_curve import TouchCurve
from .tracing import FoldTracer

# Number of values of one parameter at which branches along the other begin, beside its value in the
# parameter set.
_LINE_COUNT: Final = 8
# A point is on a curve if it is within this distance of it: relative to the chord between the two
# nearest points of the curve, and absolute. All are scaled.
_RELATIVE_DISTANCE: Final = 0.1
_DISTANCE: Final = 1e-6
# Least length of a chord, so that it can divide.
_MIN_CHORD: Final = 1e-100
# Where a fold curve ends, the curve of Hopf points is followed to the Bautin point on it: greatest
# number of points, and length of the first step.
_MAX_POINTS_TO_BAUTIN: Final = 40
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

    The curves are followed from events on branches that begin at Hopf points, at nine values of one
    parameter. Curves without such an event are missed. Cusps, where two curves of folds meet and
    end, and Hopf points at which folds begin (Bautin) are located along the curves.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None.
    kind : "hopf", "fold" or "touch"
        The points of the curves: Hopf points of the equilibrium, folds of limit cycles, or limit
        cycles whose highest point is at y = 0.
    over : mapping of str to tuple of float
        Lowest and highest value of two parameters; by None a tenth and ten times the set's value.
    separation : bool
        Whether the slider can separate from the belt.
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
        If no point of this kind is found in the ranges.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, boundary
    >>> result = boundary(Parameters(F=30.0), "fold", {"F": (28.0, 40.0), "mu": (0.2, 0.6)})
    >>> [(str(event.kind), round(event.values[0], 6)) for event in result.events]
    [('cusp', 36.510164)]
    """
    plane = _check_plane(system_of(parameters, separation), kind, over)
    work = Progress(progress)
    curves: list[BoundaryCurve] = []
    follow = {"hopf": _follow_hopf, "fold": _follow_folds, "touch": _follow_touches}[kind]
    # `extend` adds each curve before the generator goes on: it skips events on the curves so far.
    curves.extend(follow(plane, work, curves))
    work.advance(1.0)
    if not curves:
        names = " and ".join(plane.names)
        raise ComputationError(
            f"no {_LABELS[kind]} was found over {names}", "widen the ranges, or change the others"
        )
    return Boundary(plane.system, kind, plane.names, plane.ranges, tuple(curves))


# Names of the points, for messages.
_LABELS: Final = {"hopf": "Hopf point", "fold": "fold", "touch": "touch of y = 0"}


def _check_plane(
    system: System, kind: BoundaryKind, over: Mapping[str, tuple[float, float] | None]
) -> ParameterPlane:
    p, separation = system.parameters, system.separation
    # Refuse a belt speed: without one the slider always slides the same way.
    check_always_sliding(p, subject="boundaries; follow branches over one parameter instead")
    if kind not in BOUNDARIES:
        raise InputError(f"kind = {kind!r}: must be one of {', '.join(BOUNDARIES)}")
    if len(over) != 2:
        raise InputError(f"over: {', '.join(over)}; must be two parameters")
    if kind == "touch" and not separation:
        raise InputError("touch: separation must be considered")
    if not separation and p.k_nl == 0.0 and "k_nl" not in over and kind != "hopf":
        raise InputError("k_nl = 0: must be above 0 if separation is ignored: motion is linear")
    ranges = []
    for name, ends in over.items():
        number_spec(name)
        ranges.append(parameter_range(p, name, *((None, None) if ends is None else ends)))
    first, second = over
    return ParameterPlane(system, (first, second), (ranges[0], ranges[1]))


def _systems_to_follow(plane: ParameterPlane, work: Progress) -> Iterator[tuple[System, str, int]]:
    # Systems at values of one parameter, and name and index of the other, along which branches are
    # followed.
    varied_index = _varied_index(plane)
    fixed_index = 1 - varied_index
    low, high = plane.ranges[fixed_index]
    name = plane.names[fixed_index]
    set_value = getattr(plane.system.parameters, name)
    values = [set_value] if low <= set_value <= high else []
    values += [low + (high - low) * (index + 0.5) / _LINE_COUNT for index in range(_LINE_COUNT)]
    for count, value in enumerate(values):
        work.report(count / (_LINE_COUNT + 1))
        yield plane.system.with_values({name: value}), plane.names[varied_index], varied_index


def _varied_index(plane: ParameterPlane) -> int:
    # Index of the parameter along which branches are followed: that of μ, as along μ there is at
    # most one Hopf point (see `critical_mu`); the second parameter if neither is μ.
    return 0 if plane.names[0] == "mu" else 1


def _branch_events(
    plane: ParameterPlane, kind: EventKind, work: Progress
) -> Iterator[tuple[System, CyclePoint, FloatArray]]:
    # The system, the cycle and the values of both parameters at each event of a kind on branches.
    for system, name, varied_index in _systems_to_follow(plane, work):
        p = system.parameters
        low, high = plane.ranges[varied_index]
        try:
            cycles = branch(p, name, low=low, high=high, separation=system.separation)
        except ComputationError:
            continue
        for point in cycles.points:
            if event_at(cycles, point) is kind:
                values = [getattr(p, parameter) for parameter in plane.names]
                values[varied_index] = point.value
                yield system.with_values({name: point.value}), point, np.array(values)


def _follow_folds(
    plane: ParameterPlane, work: Progress, curves: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    for system, cycle, values in _branch_events(plane, EventKind.FOLD, work):
        if _is_on_a_curve(plane, curves, values, (cycle.period, cycle.y_min, cycle.y_max)):
            continue
        tracer = FoldTracer(plane, length_scale(system), cycle.period, work)
        start = tracer.fold_at(np.array([*cycle.start, cycle.period, *values]), cycle.y_max)
        if start is not None:
            convert = partial(_cycle_point, tracer.scales)
            yield _add_bautin(plane, _curve_through(tracer.follow, start, convert), work)


def _follow_touches(
    plane: ParameterPlane, work: Progress, curves: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    for system, cycle, values in _branch_events(plane, EventKind.TOUCH, work):
        if _is_on_a_curve(plane, curves, values, (cycle.period, cycle.y_min, cycle.y_max)):
            continue
        curve = TouchCurve(plane, length_scale(system), cycle.period, work)
        start = curve.touching_cycle(np.array([*cycle.start, cycle.period, *values]))
        if start is not None:
            yield _curve_through(Follower(curve).follow, start, partial(_cycle_point, curve.scales))


def _follow_hopf(
    plane: ParameterPlane, work: Progress, curves: Sequence[BoundaryCurve]
) -> Iterator[BoundaryCurve]:
    curve = HopfCurve(plane, work)
    follower, convert = Follower(curve), partial(_hopf_point, plane)
    for system, name, varied_index in _systems_to_follow(plane, work):
        for value in hopf_values(system, name, *plane.ranges[varied_index]):
            values = [getattr(system.parameters, parameter) for parameter in plane.names]
            values[varied_index] = value
            start = curve.point_at((values[0], values[1]), fixed_index=1 - varied_index)
            if start is None:
                continue
            point = convert(start)
            measures = (point.period, point.y_min, point.y_max)
            if not _is_on_a_curve(plane, curves, np.array(point.values), measures):
                yield _curve_through(follower.follow, start, convert)


P = TypeVar("P", bound=PointOnCurve)


def _curve_through(
    follow: Callable[[P], CurvePart[P]], start: P, convert: Callable[[P], BoundaryPoint]
) -> BoundaryCurve:
    curve = follow_both_ways(follow, start)
    points = tuple(map(convert, curve.points))
    events = tuple(_event(kind, points[index]) for index, kind in curve.events.items())
    return BoundaryCurve(points, events, curve.ends)


def _add_bautin(plane: ParameterPlane, curve: BoundaryCurve, work: Progress) -> BoundaryCurve:
    # Add the Bautin points in which a fold curve ends: Hopf points of zero Lyapunov coefficient.
    points, events = [curve.points], [curve.events]
    first_end, last_end = curve.ends
    if first_end is End.EQUILIBRIUM:
        bautin = _bautin_points(plane, curve.points[0], work)
        points.insert(0, bautin)
        events.insert(0, tuple(_event(EventKind.BAUTIN, point) for point in bautin))
    if last_end is End.EQUILIBRIUM:
        bautin = _bautin_points(plane, curve.points[-1], work)
        points.append(bautin)
        events.append(tuple(_event(EventKind.BAUTIN, point) for point in bautin))
    return BoundaryCurve(tuple(chain(*points)), tuple(chain(*events)), curve.ends)


def _bautin_points(
    plane: ParameterPlane, fold: BoundaryPoint, work: Progress
) -> tuple[BoundaryPoint, ...]:
    # The Bautin point nearest to a fold of small amplitude; empty if it is not found.
    curve = HopfCurve(plane, work)
    start = curve.point_at(fold.values, fixed_index=1 - _varied_index(plane))
    if start is None:
        return ()
    follower = Follower(curve, max_points=_MAX_POINTS_TO_BAUTIN)
    points = follower.events_both_ways(start, EventKind.BAUTIN, _FIRST_STEP)
    points.sort(key=lambda point: float(np.linalg.norm(point.unknowns - start.unknowns)))
    return tuple(_hopf_point(plane, point) for point in points[:1])


def _event(kind: EventKind, point: BoundaryPoint) -> BoundaryEvent:
    return BoundaryEvent(kind, point.values, point.period, point.y_min, point.y_max)


def _cycle_point(scales: FloatArray, orbit: OrbitOnCurve) -> BoundaryPoint:
    x, vx, y, vy, period, first, second = (orbit.unknowns * scales).tolist()
    multipliers = tuple(orbit.multipliers.tolist())
    return BoundaryPoint(
        (first, second), period, (x, vx, y, vy), orbit.y_min, orbit.y_max, multipliers
    )


def _hopf_point(plane: ParameterPlane, point: HopfOnCurve) -> BoundaryPoint:
    first, second = (point.unknowns * plane.units).tolist()
    rest = equilibrium(plane.system_at((first, second)))
    return BoundaryPoint(
        (first, second),
        2.0 * math.pi / point.hopf.omega,
        (rest.x, 0.0, rest.y, 0.0),
        rest.y,
        rest.y,
        lyapunov=point.hopf.lyapunov,
    )


def _is_on_a_curve(
    plane: ParameterPlane,
    curves: Sequence[BoundaryCurve],
    values: FloatArray,
    measures: tuple[float, float, float],
) -> bool:
    # Whether a point, given by its parameters, period and extremes, is on one of the curves.
    period, y_min, y_max = measures
    # The unit of both extremes is the depth of the lowest point: y_max may be zero.
    depth = abs(y_min)
    units = np.array([*plane.units, period, depth, depth])
    target = np.array([*values, period, y_min, y_max]) / units
    for curve in curves:
        polyline = np.array(
            [[*point.values, point.period, point.y_min, point.y_max] for point in curve.points]
        )
        polyline /= units
        chords = np.diff(polyline, axis=0)
        lengths = np.maximum(np.linalg.norm(chords, axis=1), _MIN_CHORD)
        shares = np.clip(((target - polyline[:-1]) * chords).sum(axis=1) / lengths**2, 0.0, 1.0)
        distances = np.linalg.norm(polyline[:-1] + shares[:, None] * chords - target, axis=1)
        if (distances < _RELATIVE_DISTANCE * lengths + _DISTANCE).any():
            return True
    return False

"""Branches of limit cycles along a parameter, stable and unstable."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    ComputationError,
    InputError,
    Parameters,
    State,
    equilibrium,
    parameter_spec,
)
from fivtui.results import Result, scene_text
from fivtui.transient import Progress

from .arclength import PERIOD, VALUE, FloatArray, OrbitCurve, OrbitOnCurve
from .explorer import Explorer, Watch, starts_around
from .following import MOST_POINTS, End, EventKind, Followed, Follower
from .hopf import HopfPoint, hopf_point, hopf_values
from .shooting import PeriodicOrbit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Origin = Literal["hopf", "cycle"]

ORIGINS: Final[tuple[Origin, ...]] = ("hopf", "cycle")
# Events that a result prints.
_TOLD: Final = 8
# Bounds of the parameter, if not given: its value over and times this.
_SPAN: Final = 10.0
# Amplitude at a Hopf point, relative to the static deflection; a branch has returned at less.
_FIRST: Final = 5e-3
_RETURNED: Final = 4e-3


@dataclass(frozen=True, slots=True)
class CyclePoint:
    """A limit cycle of a branch.

    Attributes
    ----------
    value : float
        The parameter.
    period : float
        Period, s.
    start : State
        (x, ẋ, y, ẏ) of one of its states, m and m/s.
    y_min, y_max : float
        Lowest and highest point, m.
    stable : bool
        Whether neighbouring motions return to it: all multipliers are inside the unit circle.
    multipliers : tuple of complex
        Its three Floquet multipliers by falling size, without the one along the orbit, which is 1.
    """

    value: float
    period: float
    start: State
    y_min: float
    y_max: float
    stable: bool
    multipliers: tuple[complex, ...]

    @property
    def half_range(self) -> float:
        """Half peak-to-peak of y, m."""
        return 0.5 * (self.y_max - self.y_min)


@dataclass(frozen=True, slots=True)
class BranchEvent:
    """What happens at a point of a branch.

    Attributes
    ----------
    kind : EventKind
        What: the branch begins or ends in the equilibrium (hopf), the cycle begins to touch y = 0
        (touch), the branch turns back (fold), the cycle loses or gains stability to one of twice
        its period (period-doubling) or to a torus (torus), another branch crosses (branch).
    value : float
        The parameter there.
    period : float
        The period there, s.
    y_min, y_max : float
        Lowest and highest point there, m.
    direction : str
        At a Hopf point whether the cycles next to it attract: ``"supercritical"``,
        ``"subcritical"`` or ``"degenerate"``; empty at other events.
    """

    kind: EventKind
    value: float
    period: float
    y_min: float
    y_max: float
    direction: str = ""


@dataclass(frozen=True, slots=True, repr=False)
class CycleBranch(Result):
    """A branch of limit cycles along a parameter.

    Attributes
    ----------
    parameters : Parameters
        The parameters that do not vary.
    separation : bool
        Whether separation was considered.
    name : str
        The parameter that varies.
    low, high : float
        The range in which the branch was followed.
    origin : str
        Where it was begun: ``"hopf"`` or ``"cycle"``.
    points : tuple of CyclePoint
        The cycles along the branch; events other than Hopf points are among them.
    events : tuple of BranchEvent
        What happens along the branch, in the order of the points.
    ends : tuple of End
        Why it ends, at the first point and at the last; from a Hopf point it begins there.
    """

    parameters: Parameters
    separation: bool
    name: str
    low: float
    high: float
    origin: Origin
    points: tuple[CyclePoint, ...]
    events: tuple[BranchEvent, ...]
    ends: tuple[End, End]

    def _summary(self) -> list[tuple[str, str]]:
        scene = scene_text(self.parameters, separation=self.separation, without=(self.name,))
        values = [point.value for point in self.points]
        stable = sum(point.stable for point in self.points)
        rows = [
            (str(event.kind), f"{self.name} = {event.value:.10g}, period {event.period:.8g} s")
            for event in self.events[:_TOLD]
        ]
        if len(self.events) > _TOLD:
            rows.append(("and", f"{len(self.events) - _TOLD} more events"))
        return [
            ("scene", scene),
            (self.name, f"{min(values):g} to {max(values):g}"),
            ("limit cycles", f"{len(values)}, {stable} of them stable"),
            *rows,
            ("ends", "; ".join(self.ends)),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui branch --json`` prints."""
        from .files import branch_to_dict

        return branch_to_dict(self)

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """One element for every point of the branch."""
        from .files import branch_columns

        return branch_columns(self)

    def figure(self) -> "Figure":
        """Matplotlib figure of half peak-to-peak over the parameter, with the events."""
        from .figure import branch_figure

        return branch_figure(self)


def branch(
    parameters: Parameters | None,
    name: str,
    *,
    low: float | None = None,
    high: float | None = None,
    origin: Origin = "hopf",
    separation: bool = True,
    progress: Progress | None = None,
) -> CycleBranch:
    """Follow a branch of limit cycles along a parameter, through folds, stable or not.

    By pseudo-arclength continuation over shooting: folds, the first touch of y = 0, period
    doublings and tori are located to 1e-10 of the parameter. Branches that are not connected to the
    one followed are not found.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None. Of several Hopf points in the range the one
        nearest to its value of the parameter that varies is taken.
    name : str
        The parameter that varies.
    low, high : float, optional
        Range of the parameter; a tenth and ten times its value if not given.
    origin : "hopf" or "cycle"
        Where the branch begins: at a Hopf point of the equilibrium, or at the first limit cycle
        that is reached by transients of the parameter set; this one is followed both ways.
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
    p = Parameters() if parameters is None else parameters
    if origin not in ORIGINS:
        raise InputError(f"origin = {origin!r}: must be one of {', '.join(ORIGINS)}")
    bottom, top = _range(p, name, low, high)
    if not separation and p.k_nl == 0.0 and name != "k_nl":
        raise InputError("k_nl = 0: must be above 0 where separation is ignored: it is linear")
    watch = Watch(progress)
    if origin == "hopf":
        begun = _from_hopf(p, name, (bottom, top), watch, separation=separation)
    else:
        begun = _from_cycle(p, name, (bottom, top), watch, separation=separation)
    if progress is not None:
        progress(1.0)
    return CycleBranch(p, separation, name, bottom, top, origin, *begun)


_Begun = tuple[tuple[CyclePoint, ...], tuple[BranchEvent, ...], tuple[End, End]]


def _range(p: Parameters, name: str, low: float | None, high: float | None) -> tuple[float, float]:
    spec, value = parameter_spec(name), getattr(p, name)
    if (low is None or high is None) and not value > 0.0:
        raise InputError(f"{name} = {value:g}: must be above 0, or the range be given")
    bottom = max(value / _SPAN, spec.lower) if low is None else spec.check(low)
    top = min(value * _SPAN, spec.upper) if high is None else spec.check(high)
    if not bottom < top:
        raise InputError(f"{name}: {bottom:g} to {top:g}: must be a range of ascending values")
    return bottom, top


def _from_hopf(
    p: Parameters, name: str, bounds: tuple[float, float], watch: Watch, *, separation: bool
) -> _Begun:
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


def _from_cycle(
    p: Parameters, name: str, bounds: tuple[float, float], watch: Watch, *, separation: bool
) -> _Begun:
    if not bounds[0] <= getattr(p, name) <= bounds[1]:
        raise InputError(
            f"{name} = {getattr(p, name):g}: must be in the range {bounds[0]:g} to {bounds[1]:g}"
        )
    explorer = Explorer(p, separation=separation, go_on=watch.go_on)
    orbit = _first_cycle(p, explorer, separation=separation)
    curve, follower = _follower(
        p, name, (bounds, explorer.length, orbit.period), watch, separation=separation
    )
    guess = np.array([*orbit.start, orbit.period, getattr(p, name)]) / curve.scales
    fixed = np.eye(6)[VALUE]
    section = np.eye(6)[orbit.section.value]
    start = curve.solve(guess, section, fixed)
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


def _follower(
    p: Parameters,
    name: str,
    measures: tuple[tuple[float, float], float, float],
    watch: Watch,
    *,
    separation: bool,
) -> tuple[OrbitCurve, Follower]:
    (low, high), length, period = measures
    speed = 2.0 * math.pi * length / period
    # A power of two scales without rounding.
    value = 2.0 ** math.floor(math.log2(max(abs(getattr(p, name)), (high - low) / 64.0)))
    scales = np.array([length, speed, length, speed, period, value])
    curve = OrbitCurve(p, name, scales, separation=separation, go_on=watch.go_on)
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
    points = [_point(curve, orbit) for orbit in (start, *found.orbits)]
    events = [
        BranchEvent(kind, one.value, one.period, one.y_min, one.y_max)
        for place, kind in found.events.items()
        for one in [points[place + 1]]
    ]
    return points, events


def _point(curve: OrbitCurve, orbit: OrbitOnCurve) -> CyclePoint:
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

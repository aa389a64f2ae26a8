"""The result of a transient: final state, peaks, events, and how they are assembled."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    IN_CONTACT,
    Mode,
    Parameters,
    State,
    System,
    TimeTable,
    contact_force,
    horizontal_stiffness,
    transition_name,
)
from fivtui.results import Plottable, SystemResult, scene_text
from fivtui.taylor import overflow_error

from .extremes import Extremes
from .request import Kernel, Request
from .trajectory import DenseSolution, Trajectory

if TYPE_CHECKING:
    from fivtui.charts import Sheet

    from .derivatives.sensitivity import Sensitivities


_NO_TRANSITIONS: Final[Mapping[str, int]] = MappingProxyType({})
_OF_SLIDING: Final = (
    transition_name(Mode.CONTACT, Mode.SEPARATED),
    transition_name(Mode.SEPARATED, Mode.CONTACT),
)


# All pairs of modes; the index is first · number of modes + second. Flags mark separation or
# reattachment, and begin or end of stick.
_PAIRS: Final = [(first, second) for first in Mode for second in Mode]
_KINDS: Final = [transition_name(first, second) for first, second in _PAIRS]
_PLACES: Final = np.array([len(Mode), 1.0])
_LIFTS: Final = np.array([(a in IN_CONTACT) != (b in IN_CONTACT) for a, b in _PAIRS])
_STICKS: Final = np.array([(a is Mode.STICK) != (b is Mode.STICK) for a, b in _PAIRS])
_TO_STICK: Final = [kind for kind, (_, second) in enumerate(_PAIRS) if second is Mode.STICK]
NO_CHANGES: Final[NDArray[np.float64]] = np.empty((0, 3))
Tally = tuple[float, list[float]]


class FinalState(NamedTuple):
    """State at the end: t in s, x and y in m, vx and vy in m/s."""

    t: float
    x: float
    vx: float
    y: float
    vy: float


class Peak(NamedTuple):
    """Exact extremes over the whole run, m; `vx_max`, m/s, is the least valid belt speed."""

    y_abs: float
    y_max: float
    y_min: float
    x_abs: float
    vx_max: float


class Steady(NamedTuple):
    """Half peak-to-peak of y over the second half of the run, m; it may still be settling."""

    y_half_range: float


class ContactForce(NamedTuple):
    """Least and greatest contact force over the run, N."""

    min: float
    max: float


# A slip of more periods ends a groan.
_PERIODS: Final = 2.0


class Events(NamedTuple):
    """Switches of the run.

    Attributes
    ----------
    separations, reattachments : int
        Their numbers.
    separated_time : float
        Time off the belt, s.
    first, last : float or None
        Time of the first and last separation or reattachment, s.
    sticks : int
        How often the slider began to stick to the belt, at the start included.
    stick_time : float
        Time for which it stuck, s.
    transitions : dict of str to int
        Number of switches by their kind, such as ``"stick-forward"``: see `MODES`.
    """

    separations: int
    reattachments: int
    separated_time: float
    first: float | None
    last: float | None
    sticks: int = 0
    stick_time: float = 0.0
    transitions: Mapping[str, int] = _NO_TRANSITIONS


class Stop(NamedTuple):
    """What happens until a belt that slows down is at rest, times in s; None for what does not.

    Attributes
    ----------
    squeal : float or None
        First separation.
    groan_begin, groan_end : float or None
        The last time during which stick and slip alternate, two sticks or more: a slip of more than
        two periods 2π √(m/(k1 + k3/2)) ends it, and the final stick.
    final_stick : float or None
        From when on the slider sticks until the end.
    """

    squeal: float | None
    groan_begin: float | None
    groan_end: float | None
    final_stick: float | None


class ModeChange(NamedTuple):
    """A switch from one mode to another at a time t, s, on a belt of finite speed."""

    t: float
    first: Mode
    then: Mode


@dataclass(slots=True)
class Stats:
    """Work done.

    Attributes
    ----------
    steps : int
        Integration steps; an exact solution takes none.
    cpu_s : float or None
        CPU time, s, where the caller measured it.
    kernel : str or None
        What ran the method ``taylor``: ``"compiled"`` or ``"interpreted"`` code step by step, or
        the ``"exact"`` solution of a linear scene. None for other methods.
    """

    steps: int
    cpu_s: float | None = field(default=None, compare=False)
    kernel: Kernel | None = None


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Transient(SystemResult, Plottable):
    """Result of a transient.

    Attributes
    ----------
    system : System
        The system, with `parameters`, at the start where they change over time, and `separation`.
    start : State
        (x, ẋ, y, ẏ) at t = 0, m and m/s.
    t_end : float
        Horizon, s.
    method : str
        Name of the integration method.
    tol : float
        Relative tolerance.
    step : float or None
        Step asked of a fixed-step method, s.
    final, peak, steady, contact_force, events, stats
        See their classes.
    switch_times : ndarray, shape (n,)
        Times of separations and reattachments, s, alternately of one kind and the other.
    first_mode : Mode
        Mode at the start.
    changes : ndarray, shape (n, 3)
        Time, s, and modes before and after of all switches on a belt of finite speed; empty where
        the slider always slides.
    trajectory : Trajectory or None
        The motion at the times asked for.
    solution : DenseSolution or None
        The motion as a function of time, where ``"dense"`` was asked for: called with times it
        returns a `Trajectory`.
    sensitivities : Sensitivities or None
        Derivatives of final state and extremes by the parameters asked for.
    """

    system: System
    start: State
    t_end: float
    method: str
    tol: float
    step: float | None
    final: FinalState
    peak: Peak
    steady: Steady
    contact_force: ContactForce
    events: Events
    stats: Stats
    switch_times: NDArray[np.float64]
    first_mode: Mode
    trajectory: Trajectory | None = None
    solution: DenseSolution | None = None
    sensitivities: "Sensitivities | None" = None
    changes: NDArray[np.float64] = field(default_factory=lambda: NO_CHANGES)

    @property
    def over_time(self) -> Mapping[str, TimeTable]:
        """Parameters that changed with time; `parameters` are those at the start."""
        return self.system.over_time

    @property
    def separated_intervals(self) -> list[tuple[float, float]]:
        """Start and end of every interval off the belt, s."""
        edges = [0.0, *self.switch_times.tolist(), self.t_end]
        first = 1 if self.first_mode in IN_CONTACT else 0
        pairs = list(pairwise(edges))
        return [pair for pair in pairs[first::2] if pair[1] > pair[0]]

    @property
    def stick_intervals(self) -> list[tuple[float, float]]:
        """Start and end of every interval in which the slider sticks to the belt, s."""
        edges = self.changes[_STICKS[_kinds(self.changes)], 0]
        begins, ends = _sticking(self.first_mode, edges, self.t_end)
        return list(zip(begins.tolist(), ends.tolist(), strict=True))

    @property
    def mode_changes(self) -> list[ModeChange]:
        """All switches on a belt of finite speed."""
        return [
            ModeChange(t, Mode(int(first)), Mode(int(second)))
            for t, first, second in self.changes.tolist()
        ]

    @property
    def final_stick(self) -> float | None:
        """Time from which on the slider sticks until the end, s; None if it does not."""
        sticks = self.stick_intervals
        return sticks[-1][0] if sticks and sticks[-1][1] == self.t_end else None

    @property
    def stop(self) -> Stop | None:
        """Onset of squeal, groan and final stick, where the speed of the belt changes with time."""
        if "v_belt" not in self.over_time:
            return None
        off = self.separated_intervals
        begin, end = self._groan()
        return Stop(off[0][0] if off else None, begin, end, self.final_stick)

    def _groan(self) -> tuple[float, float] | tuple[None, None]:
        p = self.parameters
        longest = _PERIODS * 2.0 * math.pi * math.sqrt(p.m / horizontal_stiffness(p))
        groups: list[list[tuple[float, float]]] = []
        for stick in self.stick_intervals:
            if not groups or stick[0] - groups[-1][-1][1] > longest:
                groups.append([])
            groups[-1].append(stick)
        several = [sticks for sticks in groups if len(sticks) > 1]
        if not several:
            return None, None
        (begin, _), *_, (last_begin, released) = several[-1]
        if released == self.t_end:
            return begin, last_begin
        goes_on = several[-1] is groups[-1] and self.t_end - released <= longest
        return begin, self.t_end if goes_on else released

    def _summary(self) -> list[tuple[str, str]]:
        events, final = self.events, self.final
        off = f"{events.separated_time:.4g} s off the belt"
        state = f"x={final.x:.6g}, vx={final.vx:.6g}, y={final.y:.6g}, vy={final.vy:.6g}"
        rows = [
            (
                "scene",
                scene_text(self.system, without=tuple(self.over_time)),
            ),
            *self._over_time_rows(),
            ("run", f"{self.t_end:g} s, {self.method}, {self.stats.steps} steps"),
            ("peak |y|", f"{self.peak.y_abs:.6g} m"),
            ("half peak-to-peak of y", f"{self.steady.y_half_range:.6g} m, second half of the run"),
            (
                "separations",
                f"{events.separations}, {off} ({events.separated_time / self.t_end:.1%})",
            ),
            *self._stick_rows(),
            ("final state", state),
        ]
        if self.trajectory is not None:
            rows.append(("trajectory", f"{self.trajectory.t.size} samples"))
        if self.solution is not None:
            rows.append(("solution", "solution(times) is the motion at those times"))
        if self.sensitivities is not None:
            rows.append(("sensitivities", ", ".join(self.sensitivities)))
        return rows

    def _over_time_rows(self) -> list[tuple[str, str]]:
        phrases = [f"{name} {table.in_words()}" for name, table in self.over_time.items()]
        return [("over time", "; ".join(phrases))] if phrases else []

    def _stick_rows(self) -> list[tuple[str, str]]:
        if self.parameters.v_belt is None:
            return []
        stick_time, stop = self.events.stick_time, self.stop
        rows = [
            ("sticks", f"{self.events.sticks}, {stick_time:.4g} s ({stick_time / self.t_end:.1%})")
        ]
        if stop is not None and stop.final_stick is not None:
            rows.append(("final stick", f"from {stop.final_stick:.6g} s"))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui simulate --json`` prints: all but the trajectory."""
        from .files import transient_to_dict

        return transient_to_dict(self)

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """The trajectory as arrays by name; `InputError` if it has none."""
        from .files import trajectory_of

        return trajectory_of(self).to_columns()

    def _sheet(self) -> "Sheet":
        from .charts import transient_sheet

        return transient_sheet([self])


def assemble(
    request: Request,
    *,
    final: State,
    extremes: Extremes,
    second_half: Extremes,
    switches: NDArray[np.float64],
    separations: int,
    separated_time: float,
    stats: Stats,
    first_mode: Mode,
    trajectory: Trajectory | None,
    solution: DenseSolution | None,
    changes: NDArray[np.float64] = NO_CHANGES,
    tally: Tally | None = None,
) -> Transient:
    """The result of a run.

    `extremes` and `second_half` are the extremes over the run and its second half. `separated_time`
    is the time off the belt in s, `first_mode` the mode before the first switch. `changes` are all
    switches on a belt of finite speed, `tally` is that of `all_events`. Raises `ComputationError`
    if the contact force is beyond the floating-point range.
    """
    system, t_end = request.system, request.t_end
    p, considered = system.parameters, system.separation
    y_min, y_max = extremes.y_min, extremes.y_max
    # P decreases with y, so its extremes follow from those of y; with separation it is at least
    # zero.
    highest, lowest = (min(y_max, 0.0), min(y_min, 0.0)) if considered else (y_max, y_min)
    weakest = contact_force(p, highest, Mode.CONTACT) + 0.0
    strongest = contact_force(p, lowest, Mode.CONTACT) + 0.0
    if not math.isfinite(strongest - weakest):
        raise overflow_error(t_end, final, system)
    first_switch, last_switch = (
        (float(switches[0]), float(switches[-1])) if switches.size else (None, None)
    )
    return Transient(
        system,
        request.initial,
        t_end,
        request.method,
        request.tol,
        request.step,
        FinalState(t_end, *final),
        Peak(
            max(y_max, -y_min), y_max, y_min, max(extremes.x_max, -extremes.x_min), extremes.vx_max
        ),
        Steady(0.5 * (second_half.y_max - second_half.y_min)),
        ContactForce(weakest, strongest),
        all_events(
            Events(
                separations, switches.size - separations, separated_time, first_switch, last_switch
            ),
            p,
            first_mode,
            changes,
            t_end,
            tally=tally,
        ),
        stats,
        switches,
        first_mode,
        trajectory,
        solution,
        changes=changes,
    )


def all_events(
    events: Events,
    p: Parameters,
    first_mode: Mode,
    changes: NDArray[np.float64],
    t_end: float,
    *,
    tally: Tally | None = None,
) -> Events:
    """Events with their transitions by kind and, on a belt of finite speed, sticks.

    `tally` is the time of stick, s, and the numbers of changes by kind, if already counted.
    """
    if p.v_belt is None:
        leaves, lands = _OF_SLIDING
        counts = {leaves: events.separations, lands: events.reattachments}
        return Events(*events[:-1], counts)
    stick_time, kinds = tally or _tally(first_mode, changes, t_end)
    begins = sum(kinds[kind] for kind in _TO_STICK)
    return events._replace(
        sticks=int(begins) + (first_mode is Mode.STICK),
        stick_time=stick_time,
        transitions={name: int(count) for name, count in zip(_KINDS, kinds, strict=True) if count},
    )


def _tally(first_mode: Mode, changes: NDArray[np.float64], t_end: float) -> Tally:
    kinds = _kinds(changes)
    begins, ends = _sticking(first_mode, changes[_STICKS[kinds], 0], t_end)
    counts: list[float] = np.bincount(kinds, minlength=len(_KINDS)).tolist()
    return float((ends - begins).sum()), counts


def lift_times(changes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Times of separations and reattachments among all switches on a belt of finite speed."""
    times: NDArray[np.float64] = changes[_LIFTS[_kinds(changes)], 0]
    return times


def _kinds(changes: NDArray[np.float64]) -> NDArray[np.intp]:
    kinds: NDArray[np.intp] = (changes[:, 1:] @ _PLACES).astype(np.intp)
    return kinds


def _sticking(
    first_mode: Mode, edges: NDArray[np.float64], t_end: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # Starts and ends of all stick intervals, s, from the sorted times of their edges.
    if first_mode is Mode.STICK:
        edges = np.concatenate(([0.0], edges))
    if edges.size % 2:
        edges = np.concatenate((edges, [t_end]))
    return edges[::2], edges[1::2]

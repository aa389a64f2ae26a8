"""The result of a transient: final state, peaks, events, and how they are assembled.

A switch is a change of the mode. On a belt that is always faster than the slider, its modes are
contact and separation. On a belt of finite speed they are separation, slip forward and backward,
and stick.
"""

import math
from collections.abc import Mapping, Sequence
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
from fivtui.results import Plottable, SystemResult, Table, Tabular, scene_text
from fivtui.taylor import Extremes, overflow_error

from .request import Kernel, Request
from .trajectory import DenseSolution, Trajectory

if TYPE_CHECKING:
    from fivtui.charts import Sheet

    from .derivatives.sensitivity import Sensitivities


_NO_TRANSITIONS: Final[Mapping[str, int]] = MappingProxyType({})
# Names of the transitions on a belt that is always faster than the slider.
_SEPARATION_NAME: Final = transition_name(Mode.CONTACT, Mode.SEPARATED)
_REATTACHMENT_NAME: Final = transition_name(Mode.SEPARATED, Mode.CONTACT)

# All pairs of a mode and its successor. The index of a pair is mode · number of modes + successor:
# the scalar product of the pair, as numbers of `Mode`, and `_PAIR_WEIGHTS`.
_PAIRS: Final = [(before, after) for before in Mode for after in Mode]
_PAIR_WEIGHTS: Final = np.array([len(Mode), 1.0])
_PAIR_NAMES: Final = [transition_name(before, after) for before, after in _PAIRS]
# Pairs that begin or end contact, those that begin or end stick, and those that begin stick.
_IS_CONTACT_EDGE: Final = np.array(
    [(before in IN_CONTACT) != (after in IN_CONTACT) for before, after in _PAIRS]
)
_IS_STICK_EDGE: Final = np.array(
    [(before is Mode.STICK) != (after is Mode.STICK) for before, after in _PAIRS]
)
_STICK_STARTS: Final = [index for index, (_, after) in enumerate(_PAIRS) if after is Mode.STICK]
# Rows of `Transient.changes` of a run without switches.
NO_CHANGES: Final[NDArray[np.float64]] = np.empty((0, 3))
# A groan ends at a slip that lasts longer than this number of periods.
_MAX_SLIP_PERIODS: Final = 2.0
# Time of stick, s, and the number of switches for each of `_PAIRS`.
SwitchTotals = tuple[float, list[float]]


class FinalState(NamedTuple):
    """State at the end: t in s, x and y in m, vx and vy in m/s."""

    t: float
    x: float
    vx: float
    y: float
    vy: float


class Peak(NamedTuple):
    """Extremes over the whole run, not sampled, m, and the greatest ẋ, `vx_max`, m/s.

    Without a belt speed, the model is valid for belts faster than `vx_max`.
    """

    y_abs: float
    y_max: float
    y_min: float
    x_abs: float
    vx_max: float


class Steady(NamedTuple):
    """Half peak-to-peak of y, m, over the second half of the run, even if it has not settled."""

    y_half_range: float


class ContactForce(NamedTuple):
    """Minimum and maximum of the contact force over the run, N."""

    min: float
    max: float


class Events(NamedTuple):
    """Switches of the run.

    Attributes
    ----------
    separations, reattachments : int
        Number of separations and of reattachments.
    separated_time : float
        Time off the belt, s.
    first, last : float or None
        Time of the first and last separation or reattachment, s.
    sticks : int
        Number of intervals in which the slider sticks to the belt.
    stick_time : float
        Total time of stick, s.
    transitions : dict of str to int
        Number of switches by the names of the `Mode` before and after, such as
        ``"stick-forward"``.
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
    """Events while a belt slows down, times in s; None for an event that does not occur.

    Attributes
    ----------
    squeal : float or None
        First separation.
    groan_begin, groan_end : float or None
        Last interval in which stick and slip alternate, with at least two sticks. A slip longer
        than two periods of the horizontal vibration, or the final stick, ends it. The period is
        2π √(m/(k1 + k3/2)), with the stiffnesses of the horizontal and the 45° coupling spring.
    final_stick : float or None
        Start of the stick that lasts until the end.
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
    """Computational cost of a run.

    Attributes
    ----------
    steps : int
        Integration steps; an exact solution takes none.
    cpu_s : float or None
        CPU time, s; None if it was not measured.
    kernel : str or None
        Code that ran the method ``taylor``: ``"compiled"``, ``"interpreted"``, or ``"exact"`` for
        the closed solution of a linear scene. None for other methods.
    """

    steps: int
    cpu_s: float | None = field(default=None, compare=False)
    kernel: Kernel | None = None


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Transient(SystemResult, Tabular, Plottable):
    """Result of a transient.

    Attributes
    ----------
    system : System
        The system. Its `parameters` are those at the start if they change over time.
    start : State
        (x, ẋ, y, ẏ) at t = 0, m and m/s.
    t_end : float
        Horizon, s.
    method : str
        Name of the integration method.
    tol : float
        Relative tolerance.
    step : float or None
        Requested step of a fixed-step method, s.
    final, peak, steady, contact_force, events, stats
        See their classes.
    switch_times : ndarray, shape (n,)
        Times, s, at which separation and reattachment alternate.
    first_mode : Mode
        Mode at the start.
    changes : ndarray, shape (n, 3)
        All switches on a belt of finite speed: time, s, mode before, mode after. Empty on a belt
        that is always faster than the slider.
    trajectory : Trajectory or None
        The motion at the requested times.
    solution : DenseSolution or None
        The motion as a function of time if ``"dense"`` was requested: called with times, it
        returns a `Trajectory`.
    sensitivities : Sensitivities or None
        Derivatives of final state and extremes by the requested parameters.
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
        intervals = list(pairwise([0.0, *self.switch_times.tolist(), self.t_end]))
        # Intervals of contact and of separation alternate.
        first = 1 if self.first_mode in IN_CONTACT else 0
        return [(start, end) for start, end in intervals[first::2] if end > start]

    @property
    def stick_intervals(self) -> list[tuple[float, float]]:
        """Start and end of every interval in which the slider sticks to the belt, s."""
        edge_times = self.changes[_IS_STICK_EDGE[_pair_indices(self.changes)], 0]
        starts, ends = _stick_bounds(self.first_mode, edge_times, self.t_end)
        return list(zip(starts.tolist(), ends.tolist(), strict=True))

    @property
    def mode_changes(self) -> list[ModeChange]:
        """All switches on a belt of finite speed."""
        return [
            ModeChange(t, Mode(int(before)), Mode(int(after)))
            for t, before, after in self.changes.tolist()
        ]

    @property
    def final_stick(self) -> float | None:
        """Start of the stick that lasts until the end, s; None if the run ends otherwise."""
        sticks = self.stick_intervals
        return sticks[-1][0] if sticks and sticks[-1][1] == self.t_end else None

    @property
    def stop(self) -> Stop | None:
        """Times of squeal, groan and final stick; None if the speed of the belt is constant."""
        if "v_belt" not in self.over_time:
            return None
        separated = self.separated_intervals
        begin, end = self._groan()
        return Stop(separated[0][0] if separated else None, begin, end, self.final_stick)

    def _groan(self) -> tuple[float, float] | tuple[None, None]:
        # Start and end of the last groan: sticks in succession without a long slip between them.
        p = self.parameters
        max_slip = _MAX_SLIP_PERIODS * 2.0 * math.pi * math.sqrt(p.m / horizontal_stiffness(p))
        # Starts and ends of sticks.
        groups: list[list[tuple[float, float]]] = []
        previous_end = -math.inf
        for start, end in self.stick_intervals:
            if start - previous_end > max_slip:
                groups.append([])
            groups[-1].append((start, end))
            previous_end = end
        groans = [sticks for sticks in groups if len(sticks) > 1]
        if not groans:
            return None, None
        last_groan = groans[-1]
        groan_begin, _ = last_groan[0]
        last_stick_begin, last_stick_end = last_groan[-1]
        if last_stick_end == self.t_end:
            # The last stick lasts until the end of the run; it is the final stick.
            return groan_begin, last_stick_begin
        # The groan continues until the end if neither a stick nor a long slip follows it.
        continues = last_groan is groups[-1] and self.t_end - last_stick_end <= max_slip
        return groan_begin, self.t_end if continues else last_stick_end

    def _summary(self) -> list[tuple[str, str]]:
        events, final = self.events, self.final
        off_text = f"{events.separated_time:.4g} s off the belt"
        state = f"x={final.x:.6g}, vx={final.vx:.6g}, y={final.y:.6g}, vy={final.vy:.6g}"
        rows = [
            ("scene", scene_text(self.system, without=tuple(self.over_time))),
            *self._over_time_rows(),
            ("run", f"{self.t_end:g} s, {self.method}, {self.stats.steps} steps"),
            ("peak |y|", f"{self.peak.y_abs:.6g} m"),
            ("half peak-to-peak of y", f"{self.steady.y_half_range:.6g} m, second half of the run"),
            (
                "separations",
                f"{events.separations}, {off_text} ({events.separated_time / self.t_end:.1%})",
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
        phrases = [f"{name} {table.describe(name)}" for name, table in self.over_time.items()]
        return [("over time", "; ".join(phrases))] if phrases else []

    def _stick_rows(self) -> list[tuple[str, str]]:
        if self.parameters.v_belt is None:
            return []
        stick_time, stop_times = self.events.stick_time, self.stop
        rows = [
            ("sticks", f"{self.events.sticks}, {stick_time:.4g} s ({stick_time / self.t_end:.1%})")
        ]
        if stop_times is not None and stop_times.final_stick is not None:
            rows.append(("final stick", f"from {stop_times.final_stick:.6g} s"))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui simulate --json`` prints: all but the trajectory."""
        from .files import transient_to_dict

        return transient_to_dict(self)

    def _table(self) -> Table:
        # The trajectory; `InputError` if there is none.
        from .files import finite_trajectory

        return finite_trajectory(self)._table()

    def _sheet(self) -> "Sheet":
        from .charts import transient_sheet

        return transient_sheet([self])


class SpringRange(NamedTuple):
    """Least and greatest y, m, over a part of the run with the contact spring of `p`."""

    p: Parameters
    y_min: float
    y_max: float

    def contact_force(self, *, separation: bool) -> ContactForce:
        """The extremes of P: it decreases with y, and with separation it is at least 0."""
        highest = 0.0 if separation else math.inf
        y_values = min(self.y_max, highest), min(self.y_min, highest)
        # Adding 0.0 turns −0.0 into 0.0.
        return ContactForce(*(contact_force(self.p, y, Mode.CONTACT) + 0.0 for y in y_values))


def build_transient(
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
    totals: SwitchTotals | None = None,
    ranges: Sequence[SpringRange] | None = None,
) -> Transient:
    """The result of a run.

    `extremes` and `second_half` are the extremes over the run and its second half; if the contact
    spring changes, `ranges` has those of y over the run. `separated_time` is the time off the belt
    in s, `first_mode` the mode before the first switch. `switches` are the times of separation and
    reattachment. `changes` are all switches on a belt of finite speed, and
    `totals` counts them if already known. Raises `ComputationError` if the contact force is beyond
    the floating-point range.
    """
    system, t_end = request.system, request.t_end
    p = system.parameters
    ranges = ranges or [SpringRange(p, extremes.y_min, extremes.y_max)]
    forces = [part.contact_force(separation=system.separation) for part in ranges]
    force_min, force_max = min(force.min for force in forces), max(force.max for force in forces)
    y_min, y_max = min(part.y_min for part in ranges), max(part.y_max for part in ranges)
    if not math.isfinite(force_max - force_min):
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
        # Adding 0 makes −0 a 0.
        Peak(
            max(y_max, -y_min) + 0.0,
            y_max,
            y_min,
            max(extremes.x_max, -extremes.x_min) + 0.0,
            extremes.vx_max,
        ),
        Steady(0.5 * (second_half.y_max - second_half.y_min)),
        ContactForce(force_min, force_max),
        complete_events(
            Events(
                separations, switches.size - separations, separated_time, first_switch, last_switch
            ),
            p,
            first_mode,
            changes,
            t_end,
            totals=totals,
        ),
        stats,
        switches,
        first_mode,
        trajectory,
        solution,
        changes=changes,
    )


def complete_events(
    events: Events,
    p: Parameters,
    first_mode: Mode,
    changes: NDArray[np.float64],
    t_end: float,
    *,
    totals: SwitchTotals | None = None,
) -> Events:
    """Events with the number of each transition and, on a belt of finite speed, of sticks."""
    if p.v_belt is None:
        return events._replace(
            transitions={
                _SEPARATION_NAME: events.separations,
                _REATTACHMENT_NAME: events.reattachments,
            }
        )
    stick_time, counts = totals or _count_changes(first_mode, changes, t_end)
    stick_count = sum(counts[index] for index in _STICK_STARTS)
    return events._replace(
        sticks=int(stick_count) + (first_mode is Mode.STICK),
        stick_time=stick_time,
        transitions={
            name: int(count) for name, count in zip(_PAIR_NAMES, counts, strict=True) if count
        },
    )


def _count_changes(first_mode: Mode, changes: NDArray[np.float64], t_end: float) -> SwitchTotals:
    pairs = _pair_indices(changes)
    starts, ends = _stick_bounds(first_mode, changes[_IS_STICK_EDGE[pairs], 0], t_end)
    counts: list[float] = np.bincount(pairs, minlength=len(_PAIRS)).tolist()
    return float((ends - starts).sum()), counts


def contact_switch_times(changes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Times of separations and reattachments among all switches on a belt of finite speed."""
    times: NDArray[np.float64] = changes[_IS_CONTACT_EDGE[_pair_indices(changes)], 0]
    return times


def _pair_indices(changes: NDArray[np.float64]) -> NDArray[np.intp]:
    # Indices into `_PAIRS` of the modes before and after each switch.
    pairs: NDArray[np.intp] = (changes[:, 1:] @ _PAIR_WEIGHTS).astype(np.intp)
    return pairs


def _stick_bounds(
    first_mode: Mode, edge_times: NDArray[np.float64], t_end: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # Starts and ends of all stick intervals, s, from the ascending times at which they start or end
    # within the run.
    if first_mode is Mode.STICK:
        edge_times = np.concatenate(([0.0], edge_times))
    if edge_times.size % 2:
        edge_times = np.concatenate((edge_times, [t_end]))
    return edge_times[::2], edge_times[1::2]

"""A branch of limit cycles along a parameter: its cycles and the events along it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Protocol

import numpy as np

from fivtui.model import ALL_PARAMETERS, Column, State, System
from fivtui.results import Plottable, Table, TableResult, scene_text, to_data
from fivtui.transient import START_SPECS

from .events import End, EventKind

if TYPE_CHECKING:
    from fivtui.charts import Sheet

Origin = Literal["hopf", "cycle", "file"]

# Greatest number of events in the summary of a result.
_PRINTED_EVENTS: Final = 8
# Names of events, in the order of their numbers in the column `event`.
EVENTS: Final = ("none", *EventKind)
# Multipliers of a cycle besides the one along it, which is 1.
_MULTIPLIER_COUNT: Final = 3
# Columns of quantities of a cycle, named after its attributes.
CYCLE_COLUMNS: Final = (
    Column("period", "s", "period of the limit cycle"),
    Column("y_min", "m", "lowest point"),
    Column("y_max", "m", "highest point"),
    Column("half_range", "m", "half peak-to-peak of y"),
)


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
        Its three Floquet multipliers by falling size, without the one along the orbit, which is 1;
        the last is exactly 0 where the cycle sticks.
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
    """An event at a point of a branch.

    Attributes
    ----------
    kind : EventKind
        The branch begins or ends in the equilibrium (hopf), the cycle begins to touch y = 0
        (touch), the branch turns back (fold), or another branch crosses (branch). Stability passes
        to or from a cycle of twice the period (period-doubling) or a torus (torus). Three more on
        belts of finite speed: the cycle begins or ceases to stick (stick) or to be faster than the
        belt in contact (reverse-slip); the order of its modes changes (order-of-modes). There the
        branch may have a corner, or turn back.
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

    @property
    def description(self) -> str:
        """Kind and direction, e.g. ``"hopf, subcritical"``."""
        return f"{self.kind}, {self.direction}" if self.direction else str(self.kind)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CycleBranch(TableResult, Plottable):
    """A branch of limit cycles along a parameter; its table has one row for each cycle.

    Attributes
    ----------
    system : System
        The system, with all `parameters` of the set and `separation`.
    name : str
        The parameter that varies.
    low, high : float
        The range in which the branch was followed.
    origin : str
        Where it begins: ``"hopf"``, ``"cycle"`` or ``"file"``.
    doubled : bool
        Whether it is the branch of twice the period that begins at the first period doubling.
    points : tuple of CyclePoint
        The cycles along the branch, including those at events other than Hopf points.
    events : tuple of BranchEvent
        The events along the branch, in the order of the points.
    ends : tuple of End
        Why it ends at the first and at the last point; at a Hopf point `End.EQUILIBRIUM`, also
        where the branch begins there.
    """

    data_name: ClassVar[str] = "branch"

    system: System
    name: str
    low: float
    high: float
    origin: Origin
    points: tuple[CyclePoint, ...]
    events: tuple[BranchEvent, ...]
    ends: tuple[End, End]
    doubled: bool = False

    def _summary(self) -> list[tuple[str, str]]:
        # The system in words, without the parameter that varies.
        scene = scene_text(self.system, without=(self.name,))
        values = [point.value for point in self.points]
        stable = sum(point.stable for point in self.points)
        rows = [
            (str(event.kind), f"{self.name} = {event.value:.10g}, period {event.period:.8g} s")
            for event in self.events[:_PRINTED_EVENTS]
        ]
        if len(self.events) > _PRINTED_EVENTS:
            rows.append(("and", f"{len(self.events) - _PRINTED_EVENTS} more events"))
        return [
            ("scene", scene),
            (self.name, f"{min(values):g} to {max(values):g}"),
            ("limit cycles", f"{len(values)}, {stable} of them stable"),
            *rows,
            ("ends", "; ".join(self.ends)),
        ]

    @property
    def warning(self) -> str | None:
        """Warning if the branch was lost or is too long."""
        reasons = [
            f"{end} at {self.name} = {point.value:.6g}"
            for end, point in zip(self.ends, (self.points[0], self.points[-1]), strict=True)
            if end in (End.LOST, End.TOO_LONG)
        ]
        return f"the branch {' and '.join(reasons)}" if reasons else None

    @property
    def _varied(self) -> tuple[str, ...]:
        # Not among the `parameters` of JSON and headers.
        return (self.name,)

    def _table(self) -> Table:
        points = self.points
        events = np.array([EVENTS.index(event_at(self, point) or "none") for point in points])
        return {
            ALL_PARAMETERS[self.name].column: np.array([point.value for point in points]),
            **attribute_table(points, CYCLE_COLUMNS),
            Column("stable", "1", "1 if stable"): np.array([int(point.stable) for point in points]),
            **multiplier_table(points),
            **start_table(points, "of a state on the cycle"),
            Column("event", "1", "index in events"): events,
        }

    def _header(self) -> dict[str, Any]:
        return self._branch_data() | {
            "event_kinds": [str(kind) for kind in EVENTS],
            "events": [event.description for event in self.events],
            "event_values": [event.value for event in self.events],
            "event_periods": [event.period for event in self.events],
        }

    def _branch_data(self) -> dict[str, Any]:
        return self._system_data() | {
            "range": [self.low, self.high],
            "from": self.origin,
            "doubled": self.doubled,
            "ends": [str(end) for end in self.ends],
        }

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui branch --json`` prints.

        Keys are ``parameter`` (the one that varies) and ``unit``, ``parameters`` (the others),
        ``separation``, ``range``, ``from``, ``doubled``, ``ends``, ``points`` and ``events``.
        ``ends`` says why the branch ends at the first and at the last point. ``points`` have
        ``value``, ``period``, ``y_min``, ``y_max``, ``stable``, ``multipliers`` as pairs of real
        and imaginary part, and ``start``. ``events`` have ``kind``, ``value``, ``period``,
        ``y_min``, ``y_max``, and of a Hopf point ``direction``.
        """
        return {
            "parameter": self.name,
            "unit": ALL_PARAMETERS[self.name].unit,
            **self._branch_data(),
            "points": to_data(self.points),
            "events": [
                {key: value for key, value in event.items() if value != ""}
                for event in to_data(self.events)
            ],
        }

    def _sheet(self) -> "Sheet":
        from .charts import branch_sheet

        return branch_sheet(self)


def event_at(branch: CycleBranch, point: CyclePoint) -> EventKind | None:
    """The event at one of the points of a branch, if any."""
    key = (point.value, point.period)
    return next((event.kind for event in branch.events if (event.value, event.period) == key), None)


class CycleLike(Protocol):
    """A limit cycle, or a Hopf point with its equilibrium as state and without multipliers."""

    @property
    def start(self) -> State:
        """A state of the cycle, (x, ẋ, y, ẏ)."""

    @property
    def multipliers(self) -> Sequence[complex]:
        """Its Floquet multipliers; empty at a Hopf point."""


def attribute_table(records: Sequence[object], columns: Iterable[Column]) -> Table:
    """Columns of the attributes of records; each column is named after its attribute."""
    return {
        column: np.array([getattr(record, column.name) for record in records]) for column in columns
    }


def multiplier_table(cycles: Sequence[CycleLike]) -> Table:
    """Columns of the Floquet multipliers of cycles; NaN where there are none."""
    undefined = (complex(np.nan, np.nan),) * _MULTIPLIER_COUNT
    rows = np.array([tuple(cycle.multipliers) or undefined for cycle in cycles])
    return {
        Column(
            f"multiplier_{number}_{part}", "1", f"Floquet multiplier {number}, {meaning} part"
        ): (values.real if part == "re" else values.imag)
        for number, values in enumerate(rows.T, 1)
        for part, meaning in (("re", "real"), ("im", "imaginary"))
    }


def start_table(cycles: Sequence[CycleLike], description: str) -> Table:
    """Columns of a state of each cycle, which `description` describes."""
    states = np.array([cycle.start for cycle in cycles])
    return {
        Column(spec.name, spec.unit, f"{spec.meaning}: {description}"): values
        for spec, values in zip(START_SPECS.values(), states.T, strict=True)
    }

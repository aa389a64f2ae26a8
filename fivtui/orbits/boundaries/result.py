"""Curves over two parameters on which limit cycles or the equilibrium change."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np

from fivtui.model import PARAMETERS, Column, State, System
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.result import (
    CYCLE_COLUMNS,
    attribute_table,
    multiplier_table,
    start_table,
)
from fivtui.results import Plottable, Table, TableResult, scene_text, to_data

if TYPE_CHECKING:
    from fivtui.charts import Sheet

BoundaryKind = Literal["hopf", "fold", "touch"]

BOUNDARIES: Final[tuple[BoundaryKind, ...]] = ("hopf", "fold", "touch")
# Greatest number of events in the summary of a result.
_PRINTED_EVENTS: Final = 8
_LYAPUNOV: Final = Column("lyapunov", "1/(m^2 s)", "first Lyapunov coefficient of a Hopf point")


@dataclass(frozen=True, slots=True)
class BoundaryPoint:
    """A Hopf point, fold or touching cycle.

    Attributes
    ----------
    values : tuple of float
        The two parameters.
    period : float
        Period, s.
    start : State
        (x, ẋ, y, ẏ) of a state of the cycle; the equilibrium at a Hopf point.
    y_min, y_max : float
        Lowest and highest point, m.
    multipliers : tuple of complex
        Floquet multipliers of the cycle without the one along it; none at a Hopf point.
    lyapunov : float
        First Lyapunov coefficient of a Hopf point, 1/(m² s): below zero where cycles next to it
        attract; NaN of a cycle.
    """

    values: tuple[float, float]
    period: float
    start: State
    y_min: float
    y_max: float
    multipliers: tuple[complex, ...] = ()
    lyapunov: float = float("nan")

    @property
    def half_range(self) -> float:
        """Half peak-to-peak of y, m."""
        return 0.5 * (self.y_max - self.y_min)


@dataclass(frozen=True, slots=True)
class BoundaryEvent:
    """An event at a point of a curve over two parameters.

    Attributes
    ----------
    kind : EventKind
        cusp: two curves of folds meet and end; touch: the cycle at a fold just reaches y = 0, where
        the slider leaves the belt; fold: a touching cycle is a fold; bautin: Hopf points turn from
        supercritical to subcritical, and a curve of folds begins.
    values : tuple of float
        The two parameters there.
    period : float
        The period there, s.
    y_min, y_max : float
        Lowest and highest point there, m.
    """

    kind: EventKind
    values: tuple[float, float]
    period: float
    y_min: float
    y_max: float


@dataclass(frozen=True, slots=True)
class BoundaryCurve:
    """One connected curve: its points, the events along it in their order, and why it ends."""

    points: tuple[BoundaryPoint, ...]
    events: tuple[BoundaryEvent, ...]
    ends: tuple[End, End]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Boundary(TableResult, Plottable):
    """The curves of Hopf points, folds or touches over two parameters.

    Its table has one row for each point of the curves.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    kind : str
        Kind of the points: ``"hopf"``, ``"fold"`` or ``"touch"``.
    names : tuple of str
        The two parameters.
    ranges : tuple of tuple of float
        Their ranges.
    curves : tuple of BoundaryCurve
        The curves that were found. Each is followed from a Hopf point in the ranges, or from an
        event on the branch of limit cycles that begins there. Other curves are missed.
    """

    data_name: ClassVar[str] = "boundary"

    system: System
    kind: BoundaryKind
    names: tuple[str, str]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    curves: tuple[BoundaryCurve, ...]

    @property
    def points(self) -> tuple[BoundaryPoint, ...]:
        """The points of all curves."""
        return tuple(point for curve in self.curves for point in curve.points)

    @property
    def events(self) -> tuple[BoundaryEvent, ...]:
        """The events of all curves."""
        return tuple(event for curve in self.curves for event in curve.events)

    def _summary(self) -> list[tuple[str, str]]:
        # The scene is the parameter set, and whether the slider can leave the belt.
        scene = scene_text(self.system, without=self.names)
        ranges = zip(self.names, self.ranges, strict=True)
        rows = [
            (
                str(event.kind),
                ", ".join(
                    f"{name} = {value:.10g}"
                    for name, value in zip(self.names, event.values, strict=True)
                ),
            )
            for event in self.events[:_PRINTED_EVENTS]
        ]
        if len(self.events) > _PRINTED_EVENTS:
            rows.append(("and", f"{len(self.events) - _PRINTED_EVENTS} more events"))
        return [
            ("scene", scene),
            ("over", ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in ranges)),
            (
                f"curves of {self.kind}",
                ", ".join(f"{len(curve.points)} points" for curve in self.curves),
            ),
            *rows,
        ]

    @property
    def warning(self) -> str | None:
        """Warning if a curve cannot be followed farther, or has too many points."""
        reasons = []
        for curve in self.curves:
            for end, point in zip(curve.ends, (curve.points[0], curve.points[-1]), strict=True):
                if end in (End.LOST, End.TOO_LONG):
                    texts = (
                        f"{name} = {value:.6g}"
                        for name, value in zip(self.names, point.values, strict=True)
                    )
                    reasons.append(f"{end} at {', '.join(texts)}")
        return f"a curve {' and '.join(reasons)}" if reasons else None

    @property
    def _varied(self) -> tuple[str, ...]:
        # Names of parameters that `parameters` in the data leaves out.
        return self.names

    def _table(self) -> Table:
        points = self.points
        values = np.array([point.values for point in points]).T
        point_counts = [len(curve.points) for curve in self.curves]
        curve_numbers = np.repeat(np.arange(len(self.curves)), point_counts)
        return {
            **{
                PARAMETERS[name].column: column
                for name, column in zip(self.names, values, strict=True)
            },
            Column("part", "1", "number of the curve"): curve_numbers,
            **attribute_table(points, (*CYCLE_COLUMNS, _LYAPUNOV)),
            **multiplier_table(points),
            **start_table(points, "of a state of the motion"),
        }

    def _curve_data(self) -> dict[str, Any]:
        return {"curve": self.kind, **self._system_data()}

    def _header(self) -> dict[str, Any]:
        # Entries at the top of a file with the table.
        return self._curve_data() | {
            "over": list(self.names),
            "ranges": [list(ends) for ends in self.ranges],
            "curve_events": [str(event.kind) for event in self.events],
            "curve_event_values": [list(event.values) for event in self.events],
            "ends": [[str(end) for end in curve.ends] for curve in self.curves],
        }

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui branch --curve … --json`` prints.

        Keys are ``curve`` (what is on the curves), ``over`` (name, unit and range of both
        parameters), ``parameters`` (the others), ``separation`` and ``curves``. Each of ``curves``
        has ``points``, ``events`` and ``ends``. ``points`` have ``values``, ``period``, ``y_min``,
        ``y_max``, ``start``, of a cycle ``multipliers``, and of a Hopf point ``lyapunov``.
        ``events`` have ``kind``, ``values``, ``period``, ``y_min`` and ``y_max``.
        """
        return {
            **self._curve_data(),
            "over": [
                {"name": name, "unit": PARAMETERS[name].unit, "range": list(ends)}
                for name, ends in zip(self.names, self.ranges, strict=True)
            ],
            "curves": [
                {
                    "points": [_point_data(point) for point in curve.points],
                    "events": to_data(curve.events),
                    "ends": to_data(curve.ends),
                }
                for curve in self.curves
            ],
        }

    def _sheet(self) -> "Sheet":
        from .charts import boundary_sheet

        return boundary_sheet(self)


def _point_data(point: BoundaryPoint) -> dict[str, Any]:
    # A Hopf point has no multipliers, a cycle no Lyapunov coefficient.
    data: dict[str, Any] = to_data(point)
    del data["lyapunov" if point.multipliers else "multipliers"]
    return data

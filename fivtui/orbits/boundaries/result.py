"""Curves over two parameters on which limit cycles or the equilibrium change."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from numpy.typing import NDArray

from fivtui.model import State, System
from fivtui.orbits.curves.events import End, EventKind
from fivtui.results import SystemResult, scene_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BoundaryKind = Literal["hopf", "fold", "touch"]

BOUNDARIES: Final[tuple[BoundaryKind, ...]] = ("hopf", "fold", "touch")
# Events that a result prints.
_TOLD: Final = 8


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
    """What happens at a point of a curve over two parameters.

    Attributes
    ----------
    kind : EventKind
        What: two curves of folds meet and end (cusp), a fold begins to touch y = 0 (touch) or a
        touching cycle is a fold (fold), Hopf points turn from supercritical to subcritical and a
        curve of folds begins (bautin).
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
class Boundary(SystemResult):
    """The curves of Hopf points, folds or touches over two parameters.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    kind : str
        What is on the curves: ``"hopf"``, ``"fold"`` or ``"touch"``.
    names : tuple of str
        The two parameters.
    ranges : tuple of tuple of float
        Their ranges.
    curves : tuple of BoundaryCurve
        The curves found. One that is not connected to a branch that begins at a Hopf point in the
        ranges is not found.
    """

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
            for event in self.events[:_TOLD]
        ]
        if len(self.events) > _TOLD:
            rows.append(("and", f"{len(self.events) - _TOLD} more events"))
        return [
            ("scene", scene),
            ("over", ", ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in ranges)),
            (f"curves of {self.kind}", ", ".join(f"{len(c.points)} points" for c in self.curves)),
            *rows,
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui branch --curve … --json`` prints."""
        from .files import boundary_to_dict

        return boundary_to_dict(self)

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """One element for every point of the curves."""
        from .files import boundary_columns

        return boundary_columns(self)

    def figure(self) -> "Figure":
        """Matplotlib figure of the curves in the plane of the parameters, with the events."""
        from .figure import boundary_figure

        return boundary_figure(self)

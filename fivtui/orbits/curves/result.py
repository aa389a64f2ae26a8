"""A branch of limit cycles along a parameter: its cycles and the events along it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from numpy.typing import NDArray

from fivtui.model import State, System
from fivtui.results import SystemResult, scene_text

from .events import End, EventKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Origin = Literal["hopf", "cycle", "file"]

# Events that a result prints.
_TOLD: Final = 8


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
    """What happens at a point of a branch.

    Attributes
    ----------
    kind : EventKind
        What: the branch begins or ends in the equilibrium (hopf), the cycle begins to touch y = 0
        (touch), the branch turns back (fold), the cycle loses or gains stability to one of twice
        its period (period-doubling) or to a torus (torus), another branch crosses (branch). On a
        belt of finite speed the cycle begins or ceases to stick (stick) or to be faster than the
        belt in contact (reverse-slip), or passes its modes in another order (order-of-modes): there
        the branch may have a corner, or turn back.
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


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CycleBranch(SystemResult):
    """A branch of limit cycles along a parameter.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    name : str
        The parameter that varies.
    low, high : float
        The range in which the branch was followed.
    origin : str
        Where it was begun: ``"hopf"``, ``"cycle"`` or ``"file"``.
    doubled : bool
        Whether it is the branch of twice the period that begins at the first period doubling.
    points : tuple of CyclePoint
        The cycles along the branch; events other than Hopf points are among them.
    events : tuple of BranchEvent
        What happens along the branch, in the order of the points.
    ends : tuple of End
        Why it ends, at the first point and at the last; from a Hopf point it begins there.
    """

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
        scene = scene_text(self.system, without=(self.name,))
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

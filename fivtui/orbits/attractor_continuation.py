"""Attractors along a parameter, followed by transients from value to value, up and then down.

An attractor is a limit cycle, the equilibrium, or another kind of motion on which transients end.
The standard starts are the static start, at rest at the equilibrium of μ = 0, and releases at rest
at several heights above and below the equilibrium.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    ALL_PARAMETERS,
    Column,
    InputError,
    OnProgress,
    Parameters,
    ParameterSpec,
    Progress,
    State,
    System,
    check_off_edge,
    check_varied_are_used,
    parameter_spec,
    system_of,
)
from fivtui.results import Plottable, Table, TableResult, scene_text
from fivtui.transient import Kernel

from .explorer import AT_REST, Attractor, Explorer, Kind, add_attractor, standard_starts

if TYPE_CHECKING:
    from fivtui.charts import Sheet

Direction = Literal["up", "down"]

DIRECTIONS: Final[tuple[Direction, ...]] = ("up", "down")
# Kinds of attractors, in the order of their numbers in tables.
KINDS: Final = tuple(Kind)
# Columns of attractors, named after the attributes of their orbits.
_MEASURE_COLUMNS: Final = (
    Column("period", "s", "period of the limit cycle"),
    Column("half_range", "m", "half peak-to-peak of y"),
    Column("y_min", "m", "lowest point"),
    Column("y_max", "m", "highest point"),
    Column("separations", "1", "separations per period"),
    Column("separated_time", "s", "time off the belt per period"),
    Column("sticks", "1", "sticks per period"),
    Column("stick_time", "s", "time of stick per period"),
    Column("vx_max", "m/s", "greatest horizontal velocity"),
    Column("force_max", "N", "greatest contact force"),
)
# Offset of a start from the equilibrium, in characteristic lengths: motion leaves an unstable one.
_REST_OFFSET: Final = 1e-4


@dataclass(frozen=True, slots=True)
class BranchPoint:
    """An attractor at a value of the parameter, and the directions in which it was found."""

    value: float
    directions: tuple[Direction, ...]
    attractor: Attractor


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Continuation(TableResult, Plottable):
    """Attractors along a parameter; its table has one row for each attractor at each value.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    name : str
        The parameter.
    values : ndarray, shape (n,)
        Its values.
    points : tuple of BranchPoint
        Every attractor found at every value, in the order of the values.
    """

    data_name: ClassVar[str] = "attractor"

    system: System
    name: str
    values: NDArray[np.float64]
    points: tuple[BranchPoint, ...]

    @property
    def coexisting(self) -> list[float]:
        """Values at which the equilibrium and another attractor coexist, ascending."""
        kinds_at: dict[float, set[Kind]] = {}
        for point in self.points:
            kinds_at.setdefault(point.value, set()).add(point.attractor.kind)
        return sorted(
            value
            for value, kinds in kinds_at.items()
            if kinds & {*AT_REST} and kinds - {*AT_REST, Kind.UNSETTLED}
        )

    @property
    def warning(self) -> str | None:
        """Warning if the equilibrium and another attractor coexist."""
        if not self.coexisting:
            return None
        values = ", ".join(f"{value:.6g}" for value in self.coexisting)
        return f"a stable equilibrium coexists with vibration at {self.name} = {values}"

    @property
    def _varied(self) -> tuple[str, ...]:
        # Files and JSON omit this parameter of `system`, as its value varies.
        return (self.name,)

    def _summary(self) -> list[tuple[str, str]]:
        # The scene of a result is its parameter set, and whether separation is considered.
        scene = scene_text(self.system, without=(self.name,))
        range_text = f"{self.values[0]:g} to {self.values[-1]:g}, {self.values.size} values"
        kinds = Counter(str(point.attractor.kind) for point in self.points)
        values = self.coexisting
        coexistence = f"{len(values)} values, {values[0]:g} to {values[-1]:g}" if values else "none"
        return [
            ("scene", scene),
            (self.name, range_text),
            ("attractors", ", ".join(f"{kind} {count}" for kind, count in kinds.items())),
            ("coexistence", coexistence),
        ]

    def _table(self) -> Table:
        points = self.points
        kinds = np.array([KINDS.index(point.attractor.kind) for point in points])
        return {
            ALL_PARAMETERS[self.name].column: np.array([point.value for point in points]),
            **{
                Column(direction, "1", f"1 if found going {direction}"): np.array(
                    [int(direction in point.directions) for point in points]
                )
                for direction in DIRECTIONS
            },
            Column("kind", "1", "index in kinds"): kinds,
            **{
                column: np.array([_measure(point.attractor, column.name) for point in points])
                for column in _MEASURE_COLUMNS
            },
        }

    def _header(self) -> dict[str, Any]:
        return self._system_data() | {"kinds": [str(kind) for kind in KINDS]}

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """One element for every attractor at every value; NaN for quantities that do not apply."""
        kinds = np.array([str(point.attractor.kind) for point in self.points])
        return TableResult.to_columns(self) | {"kind": kinds}

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui attractors --vary … --json`` prints.

        Keys are ``parameters`` (those that do not vary), ``separation``, ``name``, ``unit``,
        ``points`` (``value``, ``directions`` and the attractor) and ``coexisting``: the values at
        which the equilibrium and another attractor coexist.
        """
        return {
            **self._system_data(),
            "name": self.name,
            "unit": ALL_PARAMETERS[self.name].unit,
            "points": [
                {
                    "value": point.value,
                    "directions": list(point.directions),
                    **point.attractor.to_dict(),
                }
                for point in self.points
            ],
            "coexisting": self.coexisting,
        }

    def _sheet(self) -> "Sheet":
        from .charts import continuation_sheet

        return continuation_sheet(self)


def _measure(attractor: Attractor, name: str) -> float:
    # `half_range` of an attractor, or any other measure of its orbit; NaN where it has none.
    record = attractor if name == "half_range" else attractor.orbit
    value = getattr(record, name, None)
    return np.nan if value is None else float(value)


def continuation(
    parameters: Parameters | None,
    name: str,
    values: Sequence[float] | NDArray[np.float64],
    *,
    separation: bool = True,
    kernel: Kernel | None = None,
    progress: OnProgress | None = None,
) -> Continuation:
    """Follow attractors along a parameter, up and then down.

    At the first value of each direction several starts are followed to attractors. Every attractor
    is the start at the next value, so that coexisting attractors are followed side by side, and a
    branch ends where it loses its stability.

    Parameters
    ----------
    parameters : Parameters or None
        The parameters that do not vary; those of the base set if None.
    name : str
        The parameter that varies.
    values : sequence of float
        Its values, two or more, either ascending or descending.
    separation : bool
        Whether separation is considered.
    kernel : "compiled" or "interpreted", optional
        Implementation of the integrator; the compiled one where there is one, if not given.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    Continuation
        The attractors at every value.

    Raises
    ------
    InputError
        If the name is unknown, or a value is out of range.
    ComputationError
        If there is no equilibrium at a value, eigenvalues do not decide its stability (F = 0 with
        separation), or a motion cannot be followed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import continuation
    >>> result = continuation(None, "mu", [0.2, 0.5])
    >>> [(point.value, str(point.attractor.kind)) for point in result.points]
    [(0.2, 'equilibrium'), (0.5, 'separating limit cycle')]
    """
    system = system_of(parameters, separation)
    spec = varied_spec(system.parameters, name)
    ascending = np.unique([spec.check(float(value)) for value in values])
    if ascending.size < 2:
        raise InputError(f"continuation: {name}: must be two or more different values")
    for value in ascending.tolist():
        # Raises `InputError` where the other parameters do not allow the value.
        check_off_edge(system.with_values({name: value}))
    # The attractors at every value, and the directions in which each was found.
    reached_at: dict[float, list[Attractor]] = {value: [] for value in ascending.tolist()}
    directions_at: dict[float, list[list[Direction]]] = {value: [] for value in reached_at}
    work = Progress(progress)
    for turn, direction in enumerate(DIRECTIONS):
        starts: list[State] | None = None
        for step, value in enumerate(reached_at if direction == "up" else reversed(reached_at)):
            work.report((turn + step / ascending.size) / len(DIRECTIONS))
            explorer = Explorer(system.with_values({name: value}), kernel=kernel, work=work)
            if starts is None:
                starts = standard_starts(explorer)
            reached: list[Attractor] = []
            for start in starts:
                add_attractor(reached, explorer.reach(start))
            for attractor in reached:
                # The index of an equal attractor found going up, or the next free index.
                index = add_attractor(reached_at[value], attractor)
                if index == len(directions_at[value]):
                    directions_at[value].append([])
                directions_at[value][index].append(direction)
            starts = [_next_start(explorer, attractor) for attractor in reached]
    work.advance(1.0)
    points = (
        BranchPoint(value, tuple(directions), attractor)
        for value in reached_at
        for attractor, directions in zip(reached_at[value], directions_at[value], strict=True)
    )
    return Continuation(system, name, ascending, tuple(points))


def varied_spec(p: Parameters, name: str) -> ParameterSpec:
    """The specification of a parameter to vary; those of the belt need a finite belt speed.

    Raises `InputError` if there is no such parameter, or it has no effect.
    """
    spec = parameter_spec(name)
    if spec.optional and name != "v_belt" and p.v_belt is None:
        raise InputError(f"v_belt = none: must have a value to vary {name}")
    check_varied_are_used(p, (name,))
    return spec


def _next_start(explorer: Explorer, attractor: Attractor) -> State:
    # The start at the next value: on the orbit, or without one next to the equilibrium.
    if attractor.orbit is not None:
        return attractor.orbit.start
    x, vx, y, vy = explorer.rest
    return (x, vx, y + _REST_OFFSET * explorer.length, vy)

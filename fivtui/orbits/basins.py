"""Basins of attraction: the attractor that motion from each start ends in.

An escape offset is a vertical displacement from rest from which motion leaves the equilibrium's
basin.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    Column,
    InputError,
    OnProgress,
    Parameters,
    ParameterSpec,
    Progress,
    State,
    System,
    check_known,
    system_of,
)
from fivtui.results import Grid, GridResult, Plottable, Table, build_grid, scene_text, to_data
from fivtui.transient import START_SPECS, Kernel, Start, resolve_start

from .explorer import Attractor, Explorer, Kind, add_attractor

if TYPE_CHECKING:
    from fivtui.charts import Sheet

# Bounds the memory and the time of a request.
MAX_STARTS: Final = 1_000_000
# Offsets to test, in characteristic lengths: lowest, highest, number. The characteristic length is
# the greater of the static deflection and √(k2/k_nl).
_MIN_OFFSET: Final = 1e-3
_MAX_OFFSET: Final = 100.0
_OFFSET_COUNT: Final = 31
# Relative accuracy of an escape offset.
_ACCURACY: Final = 1e-4
_UPWARD, _DOWNWARD = 1.0, -1.0


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Basin(GridResult, Plottable):
    """A slice of the basins of attraction; its table has one row for each start.

    Attributes
    ----------
    system : System
        The system, with `parameters` and `separation`.
    start : State
        The start of which two components vary; (x, ẋ, y, ẏ), m and m/s.
    grid : Grid
        The two components, of `START_SPECS`, and their values, m or m/s.
    attractors : tuple of Attractor
        Every attractor that was reached.
    reached : ndarray of int, shape (n, k)
        Index in `attractors` of the attractor of each start.
    """

    # Name of the table in messages.
    data_name: ClassVar[str] = "attractor"

    system: System
    start: State
    grid: Grid
    attractors: tuple[Attractor, ...]
    reached: NDArray[np.int64]

    @property
    def counts(self) -> list[int]:
        """Number of the starts that reach each attractor."""
        indices = range(len(self.attractors))
        return [int(np.count_nonzero(self.reached == index)) for index in indices]

    @property
    def warning(self) -> str | None:
        """Warning if a motion did not settle."""
        for attractor, count in zip(self.attractors, self.counts, strict=True):
            if attractor.kind is Kind.UNSETTLED:
                return f"{count} of {self.grid.size} motions did not settle in the time allowed"
        return None

    def _summary(self) -> list[tuple[str, str]]:
        # The scene is the parameter set, and whether the slider can leave the belt.
        return [
            ("scene", scene_text(self.system)),
            *(
                (name, f"{axis[0]:g} to {axis[-1]:g}, {axis.size} values")
                for name, axis in zip(self.names, self.axes, strict=True)
            ),
            *(
                (f"attractor {index}", f"{attractor.description}: {count} of {self.grid.size}")
                for index, (attractor, count) in enumerate(
                    zip(self.attractors, self.counts, strict=True)
                )
            ),
        ]

    def _table(self) -> Table:
        attractor = Column("attractor", "1", "index in attractors")
        return {**self.grid.table(), attractor: self.reached.ravel()}

    def _header(self) -> dict[str, Any]:
        # Entries at the top of a file with the table.
        return self._start_data() | {
            "attractors": [attractor.description for attractor in self.attractors]
        }

    def _start_data(self) -> dict[str, Any]:
        return self._system_data() | {"start": list(self.start)}

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui attractors --basin … --json`` prints.

        Keys are ``parameters``, ``separation``, ``start``, ``over`` (name, unit and values of the
        two components of the start), ``attractors`` and ``reached``: for every first value a list
        of indices in ``attractors``.
        """
        return {
            **self._start_data(),
            "over": self.grid.to_data(),
            "attractors": [attractor.to_dict() for attractor in self.attractors],
            "reached": to_data(self.reached),
        }

    def _sheet(self) -> "Sheet":
        # The charts of the figure, and their layout.
        from .charts import basin_sheet

        return basin_sheet(self)


def basin(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | NDArray[np.float64]],
    *,
    separation: bool = True,
    start: Start | None = None,
    kernel: Kernel | None = None,
    progress: OnProgress | None = None,
) -> Basin:
    """Find which attractor is reached from each start in a plane.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None.
    over : mapping of str to sequence of float
        Two of ``x0``, ``vx0``, ``y0`` and ``vy0``, and the values of each, m or m/s.
    separation : bool
        Whether the slider can separate from the belt.
    start : "static" or sequence of four floats, optional
        Gives the components that do not vary: (x, ẋ, y, ẏ), or by "static" the equilibrium for
        μ = 0. By default they are those of the equilibrium.
    kernel : "compiled" or "interpreted", optional
        Implementation of the integrator; the compiled one where there is one, if not given.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    Basin
        The attractor of each start.

    Raises
    ------
    InputError
        If `over` is wrong.
    ComputationError
        If there is no equilibrium, or a motion cannot be followed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, basin
    >>> result = basin(Parameters(F=120.0), {"y0": [-0.8, 0.0], "vy0": [0.0]})
    >>> [str(result.attractors[index].kind) for index in result.reached.ravel()]
    ['equilibrium', 'separating limit cycle']
    """
    system = system_of(parameters, separation)
    if len(over) != 2:
        raise InputError(f"basin: {len(over)} start values vary; must be two different ones")
    grid = build_grid("basin", over, _start_spec)
    if grid.size > MAX_STARTS:
        raise InputError(f"basin: {grid.size} starts; must be at most {MAX_STARTS}")
    work = Progress(progress)
    explorer = Explorer(system, kernel=kernel, work=work)
    base_start = explorer.rest if start is None else resolve_start(system, start)
    components = tuple(list(START_SPECS).index(name) for name in grid.names)
    attractors: list[Attractor] = []
    reached = np.empty(grid.size, dtype=np.int64)
    for index, pair in enumerate(product(*(axis.tolist() for axis in grid.axes))):
        work.report(index / grid.size)
        state = list(base_start)
        for component, value in zip(components, pair, strict=True):
            state[component] = value
        reached[index] = add_attractor(attractors, explorer.reach(state))
    # Unlike `report`, `advance` raises no `Cancelled`: the result is complete.
    work.advance(1.0)
    return Basin(
        system=system,
        start=base_start,
        grid=grid,
        attractors=tuple(attractors),
        reached=reached.reshape(grid.shape),
    )


def _start_spec(name: str) -> ParameterSpec:
    check_known("start value", name, START_SPECS)
    return START_SPECS[name]


@dataclass(frozen=True, slots=True)
class EscapeOffset:
    """The smallest offsets up and down from the equilibrium that leave its basin, m, both positive.

    None if no tested offset leaves the basin, or if motion from a smaller one does not settle.
    """

    up: float | None
    down: float | None


def escape_offset(
    system: System,
    *,
    kernel: Kernel | None = None,
    progress: OnProgress | None = None,
) -> EscapeOffset | None:
    """The smallest vertical offsets that leave the basin of a stable equilibrium.

    The slider is released at rest above and below the equilibrium at growing offsets, up to a
    hundred characteristic lengths. The first offset without return is refined by bisection to 1e-4.
    None if the equilibrium is not stable. Raises `ComputationError` if a motion cannot be followed,
    and `Cancelled`.
    """
    work = Progress(progress)
    explorer = Explorer(system, kernel=kernel, work=work)
    if not explorer.equilibrium_attracts:
        return None
    up, down = (
        _escape_offset_in(explorer, direction, work.stage(0.5 * index, 0.5 * (index + 1)))
        for index, direction in enumerate((_UPWARD, _DOWNWARD))
    )
    work.advance(1.0)
    return EscapeOffset(up, down)


def _escape_offset_in(explorer: Explorer, direction: float, work: Progress) -> float | None:
    # The smallest offset in a direction, 1 or -1, that leaves the basin. None without one, or if a
    # smaller offset cannot be classified, as its motion does not settle.
    x, _, y, _ = explorer.rest

    def kind_at(offset: float) -> Kind:
        return explorer.reach((x, 0.0, y + direction * offset, 0.0)).kind

    offsets = (explorer.length * np.geomspace(_MIN_OFFSET, _MAX_OFFSET, _OFFSET_COUNT)).tolist()
    returning_offset = 0.0
    for index, offset in enumerate(offsets):
        work.report(index / len(offsets))
        kind = kind_at(offset)
        if kind is Kind.UNSETTLED:
            return None
        if kind is not Kind.EQUILIBRIUM:
            return _bisect_offset(kind_at, returning_offset, offset)
        returning_offset = offset
    return None


def _bisect_offset(kind_at: Callable[[float], Kind], returning: float, escaping: float) -> float:
    # The smallest offset that escapes, between one that returns and one that escapes.
    while escaping - returning > _ACCURACY * escaping:
        middle = 0.5 * (returning + escaping)
        if kind_at(middle) is Kind.EQUILIBRIUM:
            returning = middle
        else:
            escaping = middle
    return escaping

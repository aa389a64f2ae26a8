"""Basins of attraction: which start reaches which attractor, and the offset that escapes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, Parameters, State, System, system_of, unknown_name
from fivtui.results import SystemResult, scene_text
from fivtui.transient import START_SPECS, Kernel, Progress, Start, resolve_start

from .explorer import Attractor, Explorer, Kind, Watch, add_new

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_STARTS: Final = 1_000_000
# Offsets that are tried, in characteristic lengths: from, to, and their number.
_SMALLEST: Final = 1e-3
_LARGEST: Final = 100.0
_OFFSETS: Final = 31
# Relative accuracy of an escaping offset.
_RESOLVED: Final = 1e-4


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Basin(SystemResult):
    """A slice of the basins of attraction.

    Attributes
    ----------
    system : System
        The system, with `parameters` and `separation`.
    start : State
        The start of which two components vary; (x, ẋ, y, ẏ), m and m/s.
    names : tuple of str
        The two components, names in `START_SPECS`.
    axes : tuple of ndarray, shapes (n,) and (k,)
        Their values, m or m/s.
    attractors : tuple of Attractor
        Every attractor that was reached.
    reached : ndarray of int, shape (n, k)
        Index in `attractors` of what each start reaches.
    """

    system: System
    start: State
    names: tuple[str, str]
    axes: tuple[NDArray[np.float64], NDArray[np.float64]]
    attractors: tuple[Attractor, ...]
    reached: NDArray[np.int64]

    def _summary(self) -> list[tuple[str, str]]:
        from .files import describe

        return [
            ("scene", scene_text(self.system)),
            *(
                (name, f"{axis[0]:g} to {axis[-1]:g}, {axis.size} values")
                for name, axis in zip(self.names, self.axes, strict=True)
            ),
            *(
                (f"attractor {place}", f"{describe(attractor)}: {count} of {self.reached.size}")
                for place, attractor in enumerate(self.attractors)
                for count in [np.count_nonzero(self.reached == place)]
            ),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui attractors --basin … --json`` prints."""
        from .files import basin_to_dict

        return basin_to_dict(self)

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """One element per start; ``attractor`` is an index in `attractors`."""
        from .files import basin_columns

        return basin_columns(self)

    def figure(self) -> "Figure":
        """Matplotlib figure of which attractor each start reaches."""
        from .figure import basin_figure

        return basin_figure(self)


def basin(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | NDArray[np.float64]],
    *,
    separation: bool = True,
    start: Start | None = None,
    kernel: Kernel | None = None,
    progress: Progress | None = None,
) -> Basin:
    """Find which attractor is reached from each start in a plane.

    Parameters
    ----------
    parameters : Parameters or None
        The parameter set; the base set if None.
    over : mapping of str to sequence of float
        Two of ``x0``, ``vx0``, ``y0`` and ``vy0``, and the values of each, m or m/s.
    separation : bool
        Whether separation is considered.
    start : "static" or sequence of four floats, optional
        The components of the start that do not vary; those of the equilibrium if not given.
    kernel : "compiled" or "interpreted", optional
        Implementation of the integrator; the compiled one where there is one, if not given.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    Basin
        What each start reaches.

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
    >>> found = basin(Parameters(F=120.0), {"y0": [-0.8, 0.0], "vy0": [0.0]})
    >>> [str(found.attractors[place].kind) for place in found.reached.ravel()]
    ['equilibrium', 'separating limit cycle']
    """
    system = system_of(parameters, separation)
    if len(over) != 2:
        raise InputError(f"basin: {len(over)} start values vary; must be two different ones")
    (first, rows), (second, columns) = ((name, _axis(name, over[name])) for name in over)
    total = rows.size * columns.size
    if total > MAX_STARTS:
        raise InputError(f"basin: {total} starts; must be at most {MAX_STARTS}")
    watch = Watch(progress)
    explorer = Explorer(system, kernel=kernel, go_on=watch.go_on)
    base = explorer.rest if start is None else resolve_start(system, start)
    places = tuple(list(START_SPECS).index(name) for name in (first, second))
    found: list[Attractor] = []
    reached = np.empty(total, dtype=np.int64)
    for index, pair in enumerate(product(rows.tolist(), columns.tolist())):
        watch.tell(index / total)
        state = list(base)
        for place, value in zip(places, pair, strict=True):
            state[place] = value
        reached[index] = add_new(found, explorer.reach(state))
    if progress is not None:
        progress(1.0)
    return Basin(
        system=system,
        start=base,
        names=(first, second),
        axes=(rows, columns),
        attractors=tuple(found),
        reached=reached.reshape(rows.size, columns.size),
    )


def _axis(name: str, values: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
    if name not in START_SPECS:
        raise unknown_name("start value", name, START_SPECS)
    axis = np.array(values, dtype=float)
    if axis.ndim != 1 or axis.size == 0:
        raise InputError(f"basin: {name}: must be one or more numbers")
    for extreme in (axis.min(), axis.max()):
        START_SPECS[name].check(float(extreme))
    return axis


@dataclass(frozen=True, slots=True)
class EscapeOffset:
    """The smallest offsets up and down from the equilibrium that leave its basin, m, both positive.

    None if no offset that was tried leaves the basin.
    """

    up: float | None
    down: float | None


def escape_offset(
    system: System,
    *,
    kernel: Kernel | None = None,
    progress: Progress | None = None,
) -> EscapeOffset | None:
    """The smallest vertical offsets that leave the basin of a stable equilibrium.

    The slider is released at rest above and below the equilibrium at growing offsets, up to a
    hundred characteristic lengths; the first that does not return is refined by bisection to 1e-4.
    None if the equilibrium is not stable. Raises `ComputationError` if a motion cannot be followed,
    and `Cancelled`.
    """
    watch = Watch(progress)
    explorer = Explorer(system, kernel=kernel, go_on=watch.go_on)
    if not explorer.equilibrium_attracts:
        return None
    x, _, y, _ = explorer.rest
    ladder = (explorer.length * np.geomspace(_SMALLEST, _LARGEST, _OFFSETS)).tolist()
    found: list[float | None] = []
    for turn, sign in enumerate((1.0, -1.0)):

        def end(offset: float, sign: float = sign) -> Kind:
            return explorer.reach((x, 0.0, y + sign * offset, 0.0)).kind

        inside, outside = 0.0, None
        for step, offset in enumerate(ladder):
            watch.tell((turn + step / len(ladder)) / 2.0)
            kind = end(offset)
            if kind is Kind.EQUILIBRIUM:
                inside = offset
                continue
            outside = None if kind is Kind.UNSETTLED else offset
            break
        found.append(None if outside is None else _bisected(end, inside, outside))
    if progress is not None:
        progress(1.0)
    return EscapeOffset(*found)


def _bisected(end: Callable[[float], Kind], inside: float, outside: float) -> float:
    while outside - inside > _RESOLVED * outside:
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if end(middle) is Kind.EQUILIBRIUM else (inside, middle)
    return outside

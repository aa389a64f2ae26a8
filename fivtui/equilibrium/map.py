"""Maps over two parameters: growth rate, critical μ or unstable modes of a million points.

Computed in chunks, which need little more memory than the map itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    Cancelled,
    ComputationError,
    InputError,
    Parameters,
    System,
    check_effect,
    parameter_spec,
    system_of,
    time_scale,
    unknown_name,
)
from fivtui.results import SystemResult, scene_text

from .arrays import StabilityPoints, critical_mus, is_on_belt, judge_growths

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
MapValue = Literal["growth-rate", "critical-mu", "unstable-modes"]
Progress = Callable[[float], bool]

MAP_VALUES: Final[tuple[MapValue, ...]] = get_args(MapValue)
MAX_POINTS: Final = 100_000_000
# Least difference that is drawn, as a share of the greatest value: that of three-digit numbers.
LEAST_CONTRAST: Final = 1e-3
# A chunk's arrays stay in the processor's cache.
_CHUNK: Final = 8192
# On a belt of finite speed points are judged one by one.
_CHUNK_ON_BELT: Final = 64


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StabilityMap(SystemResult):
    """A quantity over two parameters.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    names : tuple of str
        Names of the two parameters.
    axes : tuple of ndarray, shapes (n,) and (k,)
        Their values.
    value : str
        ``"growth-rate"`` (1/s), ``"critical-mu"`` or ``"unstable-modes"``.
    values : ndarray, shape (n, k)
        The quantity. NaN where there is no critical friction coefficient in range, or no
        equilibrium (F < 0 lifts the slider and k3 = 0 does not hold it).
    excess : ndarray, shape (n, k)
        Relative excess of μ h k_t over its value on the stability boundary: negative where the
        equilibrium is stable, zero on the boundary, −1 without friction coupling, NaN without
        equilibrium. On a belt of finite speed the growth rate times √(m/stiffness).
    """

    system: System
    names: tuple[str, str]
    axes: tuple[FloatArray, FloatArray]
    value: MapValue
    values: FloatArray
    excess: FloatArray

    def _summary(self) -> list[tuple[str, str]]:
        known = self.values[~np.isnan(self.values)]
        span = f"{known.min():.6g} to {known.max():.6g}" if known.size else "none"
        scene = scene_text(self.system, without=self.names)
        return [
            ("scene", scene),
            *(
                (name, f"{axis[0]:g} to {axis[-1]:g}, {axis.size} values")
                for name, axis in zip(self.names, self.axes, strict=True)
            ),
            (self.value, f"{span}; {np.count_nonzero(self.excess < 0.0)} points stable"),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui map --json`` prints."""
        from .files import map_to_dict

        return map_to_dict(self)

    def to_columns(self) -> dict[str, FloatArray]:
        """One element per point, the second parameter varying fastest; NaN for no value."""
        from .files import map_columns

        return map_columns(self)

    def figure(self) -> "Figure":
        """Matplotlib figure of the map with its stability boundary."""
        from .figure import map_figure

        return map_figure(self)


def stability_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | FloatArray],
    value: str = "growth-rate",
    *,
    separation: bool = True,
    progress: Progress | None = None,
) -> StabilityMap:
    """Map the growth rate, critical μ or number of unstable modes over two parameters.

    Parameters
    ----------
    parameters : Parameters or None
        The parameters that do not vary; those of the base set if None.
    over : mapping of str to sequence of float
        Two parameters and the values of each, in SI units.
    value : str
        ``"growth-rate"``: greatest real part of the eigenvalues, 1/s; ``"critical-mu"``: the
        friction coefficient above which the equilibrium is unstable; ``"unstable-modes"``: how
        many modes grow, 0 or 1.
    separation : bool
        Whether separation is considered; matters only for F < 0.
    progress : callable, optional
        Called with the fraction done; cancels the map by returning False.

    Returns
    -------
    StabilityMap
        Agrees with `stability` of every point to rounding.

    Raises
    ------
    InputError
        If `over` has not two parameters, a name is unknown, a value is out of range, the map has
        more than 100 000 000 points, or is one of the critical μ over μ.
    ComputationError
        If a number overflows.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import stability_map
    >>> found = stability_map(None, {"F": [20.0, 80.0], "k_nl": [50.0, 100.0]}, "critical-mu")
    >>> found.values.round(3).tolist()
    [[0.765, 0.599], [0.297, 0.439]]
    """
    system = system_of(parameters, separation)
    p = system.parameters
    if value not in MAP_VALUES:
        raise unknown_name("map value", value, MAP_VALUES)
    if len(over) != 2:
        raise InputError(f"over: {len(over)} parameters given; must be two different ones")
    check_effect(p, over)
    (first, rows), (second, columns) = ((name, _axis(name, over[name])) for name in over)
    shape = (rows.size, columns.size)
    total = rows.size * columns.size
    if total > MAX_POINTS:
        raise InputError(f"over: {total} points; must be at most {MAX_POINTS}")
    values, excess = np.empty(total), np.empty(total)
    on_belt = is_on_belt(p, over)
    chunk = _CHUNK_ON_BELT if on_belt else _CHUNK
    for start in range(0, total, chunk):
        if progress is not None and not progress(start / total):
            raise Cancelled
        place = np.arange(start, min(start + chunk, total))
        row, column = np.divmod(place, columns.size)
        varied = {first: rows[row], second: columns[column]}
        if on_belt:
            found = _on_belt(p, varied, value, np.full(place.size, separation))
            values[place], excess[place] = found
            continue
        with np.errstate(all="ignore"):
            points = StabilityPoints(p, varied, np.full(place.size, separation))
            excess[place] = points.excess()
            values[place] = _evaluated(points, value, excess[place])
        _check(points, value, values[place])
    if progress is not None:
        progress(1.0)
    return StabilityMap(
        system=system,
        names=(first, second),
        axes=(rows, columns),
        value=next(known for known in MAP_VALUES if known == value),
        values=values.reshape(shape),
        excess=excess.reshape(shape),
    )


def _on_belt(
    p: Parameters, varied: Mapping[str, FloatArray], value: str, separation: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    # The quantity of a map and the excess, from the eigenvalues of each.
    growth, stable, _ = judge_growths(p, varied, separation)
    excess = growth * time_scale(p)
    if value == "critical-mu":
        return critical_mus(p, varied, separation), excess
    if value == "growth-rate":
        return growth, excess
    modes = (~stable).astype(float)
    modes[np.isnan(growth)] = np.nan
    return modes, excess


def check_map(value: str, names: Sequence[str]) -> None:
    """Raise `InputError` if a map's value does not depend on one of its two parameters at all."""
    if value == "critical-mu" and "mu" in names:
        raise InputError(
            "critical-mu over mu: must be over two other parameters, as it does not depend on mu"
        )


def _axis(name: str, values: Sequence[float] | FloatArray) -> FloatArray:
    spec = parameter_spec(name)
    axis = np.array(values, dtype=float)
    if axis.ndim != 1 or axis.size == 0:
        raise InputError(f"over: {name}: must be one or more numbers")
    for extreme in (axis.min(), axis.max()):
        spec.check(float(extreme))
    return axis


def _evaluated(points: StabilityPoints, value: str, excess: FloatArray) -> FloatArray:
    if value == "critical-mu":
        found = points.critical_mu()
    elif value == "growth-rate":
        found = points.growth_rate()
    else:
        found = (excess > 0.0).astype(float)
    found[points.no_equilibrium] = np.nan
    return found


def _check(points: StabilityPoints, value: str, found: FloatArray) -> None:
    # NaN means "none", so an overflow must raise.
    if not np.all(np.isfinite(points.kt[~points.no_equilibrium])) or (
        value == "growth-rate" and not np.all(np.isfinite(found[~points.no_equilibrium]))
    ):
        raise ComputationError(
            "a number of the map overflows",
            "use less extreme parameters",
        )

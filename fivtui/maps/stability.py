"""Maps of growth rate, critical μ or unstable modes over two parameters, from eigenvalues.

The excess of a point is above zero where the equilibrium is unstable. Points are computed in
chunks, so that memory is little more than that of the map. With a `v_belt` the belt has a finite
speed; without, it is always faster than the slider.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.equilibrium import StabilityPoints, critical_mus, has_finite_speed, judge_stability
from fivtui.model import (
    InputError,
    OnProgress,
    Parameters,
    Progress,
    check_varied_are_used,
    parameter_spec,
    system_of,
    time_scale,
    unknown_name_error,
)
from fivtui.results import build_grid

from .result import MAP_VALUES, SAFETY_VALUES, SHOWN_COLUMN, MapValue, StabilityMap

FloatArray = NDArray[np.float64]

# Values of maps that do not depend on the friction coefficient.
MU_FREE_VALUES: Final = ("critical-mu", "safe-mu")
EIGENVALUE_VALUES: Final = tuple(value for value in MAP_VALUES if value not in SAFETY_VALUES)
MAX_POINTS: Final = 100_000_000
# Points in a chunk: its arrays fit into the cache of the processor.
_CHUNK_SIZE: Final = 8192
# On a belt of finite speed points take longer: report progress more often.
_CHUNK_SIZE_AT_FINITE_SPEED: Final = 64


def stability_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | FloatArray],
    value: str = "growth-rate",
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
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
        Whether separation is considered; it matters only for F < 0, which lifts the slider, and
        for F = 0.
    progress : callable, optional
        Called with the fraction done; cancels the map by returning False.

    Returns
    -------
    StabilityMap
        Its values agree with `stability` at every point to rounding.

    Raises
    ------
    InputError
        If `over` has not two parameters, a name is unknown, a value is out of range, or the map
        has more than 100 000 000 points.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import stability_map
    >>> result = stability_map(None, {"F": [20.0, 80.0], "k_nl": [50.0, 100.0]}, "critical-mu")
    >>> result.values.round(3).tolist()
    [[0.765, 0.599], [0.297, 0.439]]
    """
    system = system_of(parameters, separation)
    p = system.parameters
    map_kind = parse_map_value(value, EIGENVALUE_VALUES)
    check_two_parameters(over)
    check_varied_are_used(p, over)
    grid = build_grid("over", over, parameter_spec)
    total = grid.size
    check_points(total, MAX_POINTS)
    (first, second), (first_axis, second_axis) = grid.names, grid.axes
    values, excess = np.empty(total), np.empty(total)
    work = Progress(progress)
    finite_speed = has_finite_speed(p, over)
    chunk_size = _CHUNK_SIZE_AT_FINITE_SPEED if finite_speed else _CHUNK_SIZE
    for start in range(0, total, chunk_size):
        work.report(start / total)
        indices = np.arange(start, min(start + chunk_size, total))
        first_index, second_index = np.divmod(indices, second_axis.size)
        varied = {first: first_axis[first_index], second: second_axis[second_index]}
        separations = np.full(indices.size, separation)
        if finite_speed:
            values[indices], excess[indices] = _finite_speed_values(p, varied, value, separations)
            continue
        with np.errstate(all="ignore"):
            points = StabilityPoints(p, varied, separations)
            excess[indices] = points.excess()
            values[indices] = _mapped_quantity(points, value, excess[indices])
    work.advance(1.0)
    return StabilityMap(
        system=system,
        grid=grid,
        value=map_kind,
        quantities={SHOWN_COLUMN[map_kind]: values.reshape(grid.shape)},
        excess=excess.reshape(grid.shape),
    )


def _finite_speed_values(
    p: Parameters, varied: Mapping[str, FloatArray], value: str, separations: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    # The mapped quantity and the excess on a belt of finite speed, from each point's eigenvalues.
    # Here the excess is the growth rate, made dimensionless by the time √(m/stiffness) of p.
    growth, stable, _ = judge_stability(p, varied, separations)
    excess = growth * time_scale(p)
    if value == "critical-mu":
        return critical_mus(p, varied, separations), excess
    if value == "growth-rate":
        return growth, excess
    unstable_modes = (~stable).astype(float)
    unstable_modes[np.isnan(growth)] = np.nan
    return unstable_modes, excess


def compute_map(
    parameters: Parameters | None,
    over: Mapping[str, Sequence[float] | FloatArray],
    value: str,
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> StabilityMap:
    """A map of any value, by `stability_map` or `safety_map`."""
    compute = stability_map
    if parse_map_value(value, MAP_VALUES) in SAFETY_VALUES:
        # Imported late: the search for limit cycles needs modules of SciPy that load slowly.
        from .safety import safety_map as compute
    return compute(parameters, over, value, separation=separation, progress=progress)


def check_two_parameters(names: Collection[str]) -> None:
    """Raise `InputError` unless a map is over two parameters."""
    if len(names) != 2:
        raise InputError(f"over: {', '.join(names)}; must be two different parameters")


def check_map(value: str, names: Sequence[str]) -> None:
    """Raise `InputError` unless a map is over two parameters on which its value depends."""
    check_two_parameters(names)
    if value in MU_FREE_VALUES and "mu" in names:
        raise InputError(
            f"{value} over mu: must be over two other parameters, as it does not depend on mu"
        )


def parse_map_value(value: str, allowed: Sequence[MapValue]) -> MapValue:
    """The name of a map value, one of `allowed`; `InputError` for any other."""
    for name in allowed:
        if name == value:
            return name
    raise unknown_name_error("map value", value, allowed)


def check_points(count: int, limit: int) -> None:
    """Raise `InputError` if a map has more points than `limit`."""
    if count > limit:
        raise InputError(f"over: {count} points; must be at most {limit}")


def _mapped_quantity(points: StabilityPoints, value: str, excess: FloatArray) -> FloatArray:
    # The mapped quantity on a belt that is always faster; NaN without a verdict.
    if value == "critical-mu":
        values = points.critical_mu()
    elif value == "growth-rate":
        values = points.growth_rate()
    else:
        values = (excess > 0.0).astype(float)
    values[points.no_verdict] = np.nan
    return values

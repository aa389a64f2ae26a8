"""A map over two parameters: quantities at all points of a grid, as a table and as data.

A map of safety is of safe μ or of coexistence; others follow from eigenvalues alone. The scene in
the summary of a map lists the parameters that differ from the base set, which has the values of the
paper, and the effects that are ignored.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS, Column, ComputationError, System
from fivtui.results import Grid, GridResult, Plottable, Row, Table, scene_text, to_data

from .searched_points import SearchedPoint, nearest_limits

if TYPE_CHECKING:
    from fivtui.charts import Sheet

FloatArray = NDArray[np.float64]
MapValue = Literal["growth-rate", "critical-mu", "unstable-modes", "safe-mu", "coexistence"]

MAP_VALUES: Final[tuple[MapValue, ...]] = get_args(MapValue)
# Values computed from limit cycles; all others follow from eigenvalues.
SAFETY_VALUES: Final = MAP_VALUES[3:]
# Regions of a map of coexistence, and their indices.
REGIONS: Final = ("safe", "safe for small disturbances alone", "squeals")
SAFE_REGION, KNOCK_REGION, SQUEAL_REGION = range(len(REGIONS))
# Label of points whose safe μ is not known.
NOT_KNOWN: Final = "not known"
# The column of quantities that a map of each value shows.
SHOWN_COLUMN: Final[Mapping[MapValue, str]] = {
    "growth-rate": "growth_rate",
    "critical-mu": "critical_mu",
    "unstable-modes": "unstable_modes",
    "safe-mu": "safe_mu",
    "coexistence": "region",
}
COLUMNS: Final = {
    column.name: column
    for column in (
        Column("growth_rate", "1/s", "growth rate"),
        Column("unstable_modes", "", "unstable modes"),
        Column("safe_mu", "", "safe friction coefficient"),
        Column("critical_mu", "", "critical friction coefficient"),
        Column("region", "", f"0 {REGIONS[0]}, 1 {REGIONS[1]}, 2 {REGIONS[2]}"),
        Column("escape_offset", "m", "least displacement from rest that escapes"),
    )
}
# Method for safe μ, as named in the data of a map.
_CONTINUATION: Final = "continuation"
# At F = 0 the equilibrium is where contact ends. On a belt at rest the slider sticks; parameters
# with mu above mu_s are refused.
_WHY_NO_VERDICT: Final = (
    "at F = 0 with separation, lifted and held by no spring, on a belt at rest, or with mu above "
    "mu_s"
)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StabilityMap(GridResult, Plottable):
    """Quantities over two parameters.

    Attributes
    ----------
    system : System
        The system, with `parameters` that do not vary and `separation`.
    grid : Grid
        The two parameters and their values.
    value : str
        Name of the mapped value: ``"growth-rate"`` (1/s), ``"critical-mu"``, ``"unstable-modes"``,
        ``"safe-mu"`` or ``"coexistence"``.
    quantities : mapping of str to ndarray, shapes (n, k)
        All quantities that were computed, by the names of their columns.
    excess : ndarray, shape (n, k)
        Relative excess of μ h k_t over its value on the stability boundary (Routh–Hurwitz), where
        h = k3/2 couples x and y, and k_t is the tangent contact stiffness. It is negative where the
        equilibrium is stable, −1 for μ h = 0, NaN without a verdict. On a belt of finite speed it
        is the growth rate times √(m/stiffness).
    searched : tuple of SearchedPoint
        The points at which a global search was made for safe μ: the corners and the centre.
    """

    data_name: ClassVar[str] = "map"

    system: System
    grid: Grid
    value: MapValue
    quantities: Mapping[str, FloatArray]
    excess: FloatArray
    searched: tuple[SearchedPoint, ...] = field(default=())

    @property
    def values(self) -> FloatArray:
        """The mapped quantity, shape (n, k); for coexistence the index in `REGIONS`.

        NaN without a critical or safe μ, or without a verdict: F < 0 lifts the slider, and k3 = 0
        leaves it free; F = 0 with separation; the belt is at rest.
        """
        return self.quantities[SHOWN_COLUMN[self.value]]

    @property
    def column(self) -> Column:
        """Name, unit and meaning of `values`."""
        return COLUMNS[SHOWN_COLUMN[self.value]]

    @property
    def safe_mu(self) -> FloatArray:
        """Least μ of the limit cycles that continuation found, else the critical μ, shape (n, k).

        NaN without both, without a verdict, and where it exceeds the μ up to which the nearest
        global search confirms the results of continuation. KeyError if it was not computed.
        """
        return self.quantities["safe_mu"]

    @property
    def critical_mu(self) -> FloatArray:
        """The critical μ, shape (n, k), NaN without one; KeyError if it was not computed."""
        return self.quantities["critical_mu"]

    @property
    def escape(self) -> FloatArray | None:
        """Least vertical displacement from rest, m, from which the slider does not return to rest.

        Accurate to 2 %, shape (n, k), NaN outside the region of coexistence; None if it was not
        computed.
        """
        return self.quantities.get("escape_offset")

    @property
    def regions(self) -> FloatArray:
        """Index in `REGIONS`, shape (n, k), NaN if not known; KeyError if it was not computed."""
        return self.quantities["region"]

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Flags of points whose safe μ is not known: the nearest search does not confirm it."""
        if "safe_mu" not in self.quantities:
            return np.zeros(self.grid.shape, dtype=bool)
        # Where no μ is critical, NaN means no safe μ, unless the nearest search has a limit.
        has_limit = nearest_limits(self.searched, self.grid.shape) < PARAMETERS["mu"].upper
        is_missing = np.isnan(self.safe_mu) & ~np.isnan(self.excess)
        return is_missing & (has_limit | ~np.isnan(self.critical_mu))

    @property
    def missing(self) -> str:
        """Label of points that have no value and are not `unknown`."""
        return "no verdict" if self.value == "coexistence" else "none"

    @property
    def basis(self) -> str:
        """The methods for the safe μ of the map, as a phrase."""
        phrase = _CONTINUATION
        if self.searched:
            phrase += f", and a global search at {len(self.searched)} points"
        count = np.count_nonzero(self.unknown)
        if count:
            phrase += f"; not known at {count} points near searches that do not confirm it"
        return phrase

    @property
    def title(self) -> str:
        """Title of the map."""
        return "Map of safe friction" if self.of_safety else "Stability map"

    @property
    def _varied(self) -> tuple[str, ...]:
        return self.grid.names

    @property
    def of_safety(self) -> bool:
        """Whether the values of the map follow from limit cycles."""
        return self.value in SAFETY_VALUES

    def rows(self) -> list[Row]:
        """Rows of the axes, the range of the values, and the shares of the regions."""
        rows = [
            Row(spec.name, f"{_range_text(axis, spec.unit)}, {axis.size}")
            for spec, axis in zip(self.grid.specs, self.axes, strict=True)
        ]
        return rows + (self._safety_rows() if self.of_safety else self._stability_rows())

    def _stability_rows(self) -> list[Row]:
        without_value = np.count_nonzero(np.isnan(self.values))
        without_verdict = np.count_nonzero(np.isnan(self.excess))
        rows = [
            Row("points", str(self.grid.size)),
            Row(self.column.meaning, _range_text(self.values, self.column.unit)),
            Row("points without value", str(without_value)),
        ]
        if without_verdict:
            text = f"{without_verdict} of them, {_WHY_NO_VERDICT}"
            rows.append(Row("without verdict", text))
        return [*rows, Row("unstable", _share(self.excess > 0.0, self.excess))]

    def _safety_rows(self) -> list[Row]:
        rows = [Row("safe μ", _range_text(self.safe_mu))]
        if self.escape is None:
            below = _share(self.safe_mu < self.critical_mu, self.safe_mu)
            rows.append(Row("below the critical μ", below))
        else:
            rows += [
                Row(region, _share(self.values == index, self.values))
                for index, region in enumerate(REGIONS)
            ]
            rows.append(Row("offset from rest that escapes", _range_text(self.escape, "m")))
        return [*rows, Row("basis of safe μ", self.basis)]

    @property
    def failure(self) -> ComputationError | None:
        """The error of a map none of whose points has a verdict; None if one has."""
        if not np.isnan(self.excess).all():
            return None
        return ComputationError(
            f"no value at any of the {self.grid.size} points, which have no verdict: "
            f"{_WHY_NO_VERDICT}",
            "change its parameters, or the ranges",
        )

    def _summary(self) -> list[Row]:
        return [Row("scene", scene_text(self.system, without=self.names)), *self.rows()]

    def _table(self) -> Table:
        quantities = {COLUMNS[name]: array.ravel() for name, array in self.quantities.items()}
        return {**self.grid.table(), **quantities}

    def _header(self) -> dict[str, Any]:
        if not self.of_safety:
            return self._system_data()
        return self._system_data() | {
            # The method for all points; the searches follow as lists.
            "basis": _CONTINUATION,
            "searched": [list(point.indices) for point in self.searched],
            "confirmed_to": [point.confirmed_to for point in self.searched],
        }

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui map --json`` prints.

        Keys are ``parameters`` (those that do not vary), ``separation``, ``over`` (name, unit and
        values of the two that do), ``value``, ``unit`` and ``values``. ``values`` has one list for
        every value of the first parameter, None without value. A map of safe friction adds
        ``basis``, ``searched`` (indices of the points of a global search), ``confirmed_to`` (the μ
        up to which each search confirms the values) and ``critical_mu``. Where this is a number but
        the value None, the value is not known. In a map of coexistence ``values`` are indices in
        ``regions``; it adds ``safe_mu`` and ``escape_offset`` (m).
        """
        further_quantities = {
            key: array for key, array in self.quantities.items() if key != SHOWN_COLUMN[self.value]
        }
        return {
            **self._header(),
            "over": self.grid.to_data(),
            "value": self.value,
            "unit": "" if self.of_safety else self.column.unit,
            "values": to_data(self.values),
            **to_data(further_quantities),
            **({"regions": list(REGIONS)} if self.value == "coexistence" else {}),
        }

    def _sheet(self) -> "Sheet":
        from .charts import map_sheet

        return map_sheet(self)


def _share(flags: NDArray[np.bool_], values: FloatArray) -> str:
    # The share of the points with a value that have a flag, and the number of the others.
    without_value = int(np.count_nonzero(np.isnan(values)))
    count = values.size - without_value
    if not count:
        return "no point has a value"
    share = f"{np.count_nonzero(flags) / count:.1%}"
    if not without_value:
        return f"{share} of the points"
    return f"{share} of {count} points, {without_value} without value"


def _range_text(values: FloatArray, unit: str = "") -> str:
    finite = values[~np.isnan(values)]
    text = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "none"
    return f"{text} {unit}".rstrip() if finite.size else text

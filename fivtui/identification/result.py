"""The result of a fit: values with intervals, residuals, and what the data leave unknown."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from fivtui.distributions import Distribution
from fivtui.io import save_json
from fivtui.model import Column, ComputationError, InputError, System
from fivtui.options import option_arguments, read_arguments
from fivtui.results import Plottable, Row, Table, TableResult, from_data, read_result, to_data
from fivtui.scene import Scene, save_scene, scene_from_dict, scene_to_dict
from fivtui.transient import VARIABLES

from .features import Target
from .options import IdentifyOptions

if TYPE_CHECKING:
    from fivtui.charts import Sheet

Floats = NDArray[np.float64]

# Probability of the runs test below which residuals are not independent.
_INDEPENDENT: Final = 0.01
# Correlations above this are printed.
_STRONG: Final = 0.9
# Fields that are arrays, with the types of their elements.
_ARRAYS: Final[Mapping[str, type]] = {
    "correlation": float,
    "record": np.int64,
    "signal": str,
    "t": float,
    "measured": float,
    "computed": float,
}


def unit_of(key: str) -> str:
    """Unit of a fitted value; a point and the number of its file may follow the name."""
    return VARIABLES[key.partition(".")[0]].unit


class FittedValue(NamedTuple):
    """A fitted value, its 95 % interval, and its standard deviation.

    The deviation is that of the logarithm where `is_logarithmic`. Interval and deviation are None
    for a value that the data do not determine, and for one at a bound.
    """

    value: float
    low: float | None
    high: float | None
    sd: float | None
    is_logarithmic: bool

    def distribution(self) -> Distribution:
        """Distribution of the value: lognormal where its logarithm is fitted, else normal.

        Raises `InputError` without a standard deviation.
        """
        if self.sd is None:
            raise InputError(f"{self.value:g}: must be determined by the data")
        if not self.is_logarithmic:
            return Distribution("normal", (self.value, self.sd))
        mean = self.value * math.exp(0.5 * self.sd**2)
        return Distribution("lognormal", (mean, mean * math.sqrt(math.expm1(self.sd**2))))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Identification(TableResult, Plottable):
    """Parameters fitted to measurements.

    Attributes
    ----------
    scene : Scene
        The scene with the fitted values; of values per file, those of the first file.
    fit : dict of str to FittedValue
        The fitted values by name; one per file has the number of the file, as ``F.2``.
    correlation : ndarray, shape (u, u)
        Correlations of the fitted values, of logarithms where these are fitted.
    record : ndarray of int, shape (n,)
        Number of the file of each measured value, from 1.
    signal : ndarray of str, shape (n,)
        Quantity of each measured value, such as ``y``.
    t, measured, computed : ndarray, shape (n,)
        Times, s, and both signals, SI units.
    targets : dict of Target to float
        The targets and their computed values.
    residual_sd : dict of str to float
        Standard deviation of the residuals of each quantity.
    runs_test : float
        Probability of so few or so many changes of sign, if residuals are independent.
    fitted_until, measured_until : float
        Time up to which the records are fitted, and their end, s.
    misfit : float
        Greatest ratio of the residuals of a signal to the signal, as standard deviations.
    unknown : tuple of str
        What the data do not determine, a sentence each.
    at_bound : tuple of str
        Names of values at their bounds.
    converged : bool
        Whether the solver found a minimum.
    windows, starts, evaluations : int
        Numbers of growing windows, of starts of the fit, and of evaluations of all runs.
    request : tuple of Scene and IdentifyOptions, optional
        Scene and options of the command that repeats the fit; None for a fit by `identify`.
    """

    data_name: ClassVar[str] = "identification"

    scene: Scene
    fit: Mapping[str, FittedValue]
    correlation: Floats
    record: NDArray[np.int64]
    signal: NDArray[np.str_]
    t: Floats
    measured: Floats
    computed: Floats
    targets: Mapping[Target, float]
    residual_sd: Mapping[str, float]
    runs_test: float
    fitted_until: float
    measured_until: float
    misfit: float
    unknown: tuple[str, ...]
    at_bound: tuple[str, ...]
    converged: bool
    windows: int
    starts: int
    evaluations: int
    request: tuple[Scene, IdentifyOptions] | None = field(default=None, compare=False)

    @property
    def system(self) -> System:  # type: ignore[override]
        """The fitted system."""
        return self.scene.system

    @property
    def problems(self) -> tuple[str, ...]:
        """Why the values are not those of the rig, a phrase each; empty for a good fit."""
        return (
            *self.unknown,
            *(f"{name} ends at a bound: allow other values" for name in self.at_bound),
            *([] if self.converged else ["the solver did not converge: begin nearer, or fit less"]),
            *self._poor_fit(),
        )

    def _poor_fit(self) -> list[str]:
        problems = []
        if self.fitted_until < self.measured_until:
            problems.append(
                f"only the first {self.fitted_until:.4g} s are fitted: the run leaves the record"
            )
        if self.runs_test < _INDEPENDENT:
            problems.append(
                f"residuals are {self.misfit:.2g} of the signal and not independent: the model "
                "differs from the rig, and the intervals are too narrow"
            )
        return problems

    @property
    def warning(self) -> str | None:
        """The problems in one sentence; None for a good fit."""
        return "; ".join(self.problems) or None

    def _summary(self) -> list[Row]:
        rows = []
        for name, fitted in self.fit.items():
            note = "" if fitted.low is None else f"95 %: {fitted.low:.6g} to {fitted.high:.6g}"
            rows.append(Row(name, f"{fitted.value:.6g} {unit_of(name)}".rstrip(), note))
        rows += [
            Row(f"target {target.name}", f"{value:.6g}", f"{target.value:g} ± {target.sd:g}")
            for target, value in self.targets.items()
        ]
        rows += [
            Row(f"residuals of {name}", f"{sd:.3g}", "standard deviation")
            for name, sd in self.residual_sd.items()
        ]
        rows += [
            Row("correlation", f"{value:.3f}", f"of {first} and {second}")
            for first, second, value in self._strong_correlations()
        ]
        if self.t.size:
            rows.append(
                Row("runs test", f"{self.runs_test:.2g}", f"not independent below {_INDEPENDENT:g}")
            )
            work = f"windows {self.windows}, starts {self.starts}, runs {self.evaluations}"
            rows.append(Row("fitted", f"0 to {self.fitted_until:.6g} s", work))
        return [*rows, *(Row("not known", text) for text in self.problems)]

    def _strong_correlations(self) -> list[tuple[str, str, float]]:
        return [
            (first, second, float(self.correlation[i, j]))
            for i, first in enumerate(self.fit)
            for j, second in enumerate(self.fit)
            if i < j and abs(self.correlation[i, j]) > _STRONG
        ]

    def _table(self) -> Table:
        return {
            Column("record", "1", "number of the file"): self.record,
            Column("signal", "", "measured quantity"): self.signal,
            Column("t", "s", "time"): self.t,
            Column("measured", "", "measured signal, SI unit"): self.measured,
            Column("computed", "", "computed signal, SI unit"): self.computed,
        }

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui identify --json`` prints."""
        names = list(self.fit)
        return self._system_data() | {
            "fit": {
                name: {"value": fitted.value, "low": fitted.low, "high": fitted.high}
                for name, fitted in self.fit.items()
            },
            "correlation": {
                name: dict(zip(names, row, strict=True))
                for name, row in zip(names, to_data(self.correlation), strict=True)
            },
            "targets": {target.name: value for target, value in self.targets.items()},
            "residual_sd": dict(self.residual_sd),
            "runs_test": self.runs_test,
            "misfit": self.misfit,
            "fitted_until": self.fitted_until,
            "converged": self.converged,
            "windows": self.windows,
            "starts": self.starts,
            "evaluations": self.evaluations,
            "not_known": list(self.problems),
        }

    def fitted_scene(self) -> Scene:
        """The scene with the fitted values, and their distributions and correlations.

        Raises `ComputationError` where the fit does not determine all values.
        """
        if self.unknown or self.at_bound or not self.converged:
            raise ComputationError(f"there is no fitted scene: {self.warning}", "fit fewer values")
        # Of values per file, those of the first file.
        first = [i for i, key in enumerate(self.fit) if key.partition(".")[2] in ("", "1")]
        names = [key.partition(".")[0] for key in self.fit]
        fitted = list(self.fit.values())
        return replace(
            self.scene,
            name="fitted",
            description="parameters fitted to measurements",
            scatter=tuple((names[i], fitted[i].distribution()) for i in first),
            correlation=tuple(
                (names[i], names[j], float(self.correlation[i, j]))
                for i in first
                for j in first
                if i < j
            ),
        )

    def _sheet(self) -> "Sheet":
        from .charts import identification_sheet

        return identification_sheet(self)


def save_fitted_scene(result: Identification, path: Path) -> None:
    """Write the fitted scene as TOML."""
    save_scene(result.fitted_scene(), path)


# Fields that JSON has as they are.
_PLAIN: Final = [
    entry.name
    for entry in fields(Identification)
    if entry.name not in (*_ARRAYS, "scene", "targets", "request")
]


def store_identification(result: Identification, path: Path) -> None:
    """Write a fit as JSON that `restore_identification` reads."""
    data = {name: to_data(getattr(result, name)) for name in (*_PLAIN, *_ARRAYS)}
    data["scene"] = scene_to_dict(result.scene)
    data["targets"] = to_data(list(result.targets.items()))
    if result.request is not None:
        scene, options = result.request
        data["request"] = {"scene": scene_to_dict(scene), "options": option_arguments(options)}
    save_json(data, path)


def restore_identification(path: Path) -> Identification:
    """Read a fit that `store_identification` wrote; raises `InputError` if it is damaged."""
    return read_result(path, "fit", _from_stored)


def _from_stored(data: Any) -> Identification:
    types, request = get_type_hints(Identification), data.get("request")
    values: dict[str, Any] = {name: from_data(data[name], types[name]) for name in _PLAIN}
    values |= {name: np.array(data[name], dtype=kind) for name, kind in _ARRAYS.items()}
    if request is not None:
        options, _ = read_arguments(IdentifyOptions, request["options"])
        request = scene_from_dict(request["scene"]), options
    return Identification(
        scene=scene_from_dict(data["scene"]),
        targets=dict(from_data(data["targets"], list[tuple[Target, float]])),
        request=request,
        **values,
    )

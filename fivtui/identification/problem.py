"""The least-squares problem of a fit: weighted residuals of signals and features."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fivtui.model import ALL_PARAMETERS, ComputationError, InputError, Progress
from fivtui.scene import Scene

from .features import Target, compute_feature
from .signals import compute_signals, scene_at
from .unknowns import Unknown

Floats = NDArray[np.float64]

# Largest number of evaluations of one solution, and its relative tolerances: to rounding, and that
# of solutions that are only begun from.
_MAX_EVALUATIONS: Final = 100
_SOLVER_TOL: Final = 1e-14
COARSE_TOL: Final = 1e-6
_COLUMNS: Final = ("record", "signal", "t", "measured", "computed")
# Weighted residual of values at which the motion or a feature cannot be computed.
_IMPOSSIBLE: Final = 1e8


@dataclass(frozen=True, slots=True)
class Record:
    """Measured signals of one file, all at the same times."""

    source: str
    t: Floats
    # The signals by quantity, such as y or P, in SI units.
    signals: Mapping[str, Floats]


class Solution(NamedTuple):
    """A minimum of the sum of squares: coordinates of the unknowns, residuals and Jacobian."""

    z: Floats
    residuals: Floats
    jacobian: Floats
    converged: bool


@dataclass(slots=True)
class Problem:
    """Weighted residuals of records and targets as functions of the unknowns' coordinates z."""

    scene: Scene
    unknowns: Sequence[Unknown]
    records: Sequence[Record]
    targets: Sequence[Target]
    # Standard deviation of the noise of each quantity.
    noise: dict[str, float]
    work: Progress
    evaluations: int = field(default=0, init=False)

    def values(self, z: Floats, record: int = 0) -> dict[str, float]:
        """Values by name of the unknowns that concern a record."""
        return {
            unknown.name: unknown.value_at(coordinate)
            for unknown, coordinate in zip(self.unknowns, z.tolist(), strict=True)
            if unknown.record in (None, record)
        }

    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the coordinates."""
        limits = [(u.coordinate(u.low), u.coordinate(u.high)) for u in self.unknowns]
        low, high = np.array(limits).T
        return low, high

    def spreads(self) -> Floats:
        """Usual sizes of changes of the coordinates."""
        return np.array(
            [1.0 if u.is_logarithmic else max(abs(u.value), 1.0) for u in self.unknowns]
        )

    def evaluate(self, z: Floats, t_end: float = math.inf) -> tuple[Floats, Floats]:
        """Weighted residuals of the samples up to a time and of the targets, and their Jacobian."""
        self.work.check()
        self.evaluations += 1
        residuals, jacobians = [], []
        for index, record in enumerate(self.records):
            values = self.values(z, index)
            is_used = record.t <= t_end
            t = record.t[is_used]
            signals, slopes = compute_signals(self.scene, values, t, [*record.signals], self.work)
            for column, (quantity, measured) in enumerate(record.signals.items()):
                noise = self.noise[quantity]
                residuals.append((signals[:, column] - measured[is_used]) / noise)
                jacobians.append(
                    self._by_coordinates(slopes[:, column], [*values], values, index) / noise
                )
        for target in self.targets:
            values = self.values(z)
            names = [name for name in values if name in ALL_PARAMETERS]
            system = scene_at(self.scene, values).system
            feature, changes = compute_feature(system, target.name, names)
            residuals.append(np.array([(feature - target.value) / target.sd]))
            jacobians.append(self._by_coordinates(changes[None], names, values, 0) / target.sd)
        return np.concatenate(residuals), np.concatenate(jacobians)

    def _by_coordinates(
        self, slopes: Floats, names: Sequence[str], values: Mapping[str, float], record: int
    ) -> Floats:
        # Derivatives by all coordinates, from those by the values `names` of one record.
        jacobian = np.zeros((len(slopes), len(self.unknowns)))
        columns = dict(zip(names, slopes.T, strict=True))
        for index, unknown in enumerate(self.unknowns):
            if unknown.record in (None, record) and unknown.name in columns:
                scale = values[unknown.name] if unknown.is_logarithmic else 1.0
                jacobian[:, index] = columns[unknown.name] * scale
        return jacobian

    def signal_residuals(self, residuals: Floats, t_end: float) -> dict[str, list[Floats]]:
        """Residuals of each quantity by record, in SI units, from those that `evaluate` returns."""
        parts: dict[str, list[Floats]] = {quantity: [] for quantity in self.noise}
        begin = 0
        for record in self.records:
            count = int(np.count_nonzero(record.t <= t_end))
            for quantity in record.signals:
                part = residuals[begin : begin + count]
                parts[quantity].append(part * self.noise[quantity])
                begin += count
        return parts

    def table(self, residuals: Floats, t_end: float) -> dict[str, NDArray[Any]]:
        """Columns of the fitted samples, the fields of `Identification` with these names."""
        parts = self.signal_residuals(residuals, t_end)
        columns: dict[str, list[NDArray[Any]]] = {name: [] for name in _COLUMNS}
        for index, record in enumerate(self.records):
            t = record.t[record.t <= t_end]
            for quantity, values in record.signals.items():
                columns["record"].append(np.full(t.size, index + 1))
                columns["signal"].append(np.full(t.size, quantity))
                columns["t"].append(t)
                columns["measured"].append(values[: t.size])
                columns["computed"].append(values[: t.size] + parts[quantity][index])
        return {name: np.concatenate(arrays or [np.empty(0)]) for name, arrays in columns.items()}

    def solve(
        self,
        z: Floats,
        t_end: float = math.inf,
        *,
        fixed: int | None = None,
        near: Floats | None = None,
        tol: float = _SOLVER_TOL,
    ) -> Solution:
        """The least sum of squares from z on; the coordinate `fixed` keeps its value.

        With `near`, the distance from there is a weak residual, so that coordinates on which the
        data hardly depend stay. Values at which the motion cannot be computed count as very bad;
        `ComputationError` if those of z are such.
        """
        free = [index for index in range(z.size) if index != fixed]
        first = self.evaluate(z, t_end)
        impossible = np.full(first[0].size, _IMPOSSIBLE), np.zeros_like(first[1])
        latest = {z[free].tobytes(): first}

        def evaluate(free_z: Floats) -> tuple[Floats, Floats]:
            key = free_z.tobytes()
            if key not in latest:
                trial = z.copy()
                trial[free] = free_z
                try:
                    result = self.evaluate(trial, t_end)
                except (ComputationError, InputError):
                    result = impossible
                latest.clear()
                latest[key] = result
            return latest[key]

        if not free:
            return Solution(z, *first, converged=True)
        low, high = self.bounds()
        tie = np.zeros(z.size) if near is None else 1.0 / self.spreads()
        tie_rows, center = np.diag(tie)[np.ix_(free, free)], (z if near is None else near)[free]

        def residuals(free_z: Floats) -> Floats:
            return np.append(evaluate(free_z)[0], tie_rows @ (free_z - center))

        def jacobian(free_z: Floats) -> Floats:
            return np.vstack([evaluate(free_z)[1][:, free], tie_rows])

        fit: Any = least_squares(
            residuals,
            np.clip(z, low, high)[free],
            jacobian,
            bounds=(low[free], high[free]),
            x_scale="jac",
            ftol=tol,
            xtol=tol,
            gtol=tol,
            max_nfev=_MAX_EVALUATIONS,
        )
        solution = z.copy()
        solution[free] = fit.x
        return Solution(solution, *evaluate(fit.x), converged=fit.status > 0)

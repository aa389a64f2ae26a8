"""Escape offsets of many parameter sets: least displacements from rest that lead to vibration.

The slider is released above and below the equilibrium, at growing displacements. The fold is the
limit cycle of least μ on the branch of cycles over μ; displacements are relative to its half range.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import simulate_batch
from fivtui.kernel import Status
from fivtui.model import Progress, System, equilibrium

Floats = NDArray[np.float64]

# Tested displacements, relative to that half range: least, greatest, and their number.
_LEAST_RATIO: Final = 0.02
_GREATEST_RATIO: Final = 5.0
_RATIO_COUNT: Final = 14
# They divide the gap between two tested displacements, a factor of 1.53, by 32: to 1.7 %.
_BISECTIONS: Final = 5
# Duration of motions in decay times of the slider without friction. It is long: a motion that
# begins near an unstable cycle leaves it slowly, before it decays or escapes.
_DECAY_TIMES: Final = 12.0
_TOL: Final = 1e-6
_MAX_STEPS: Final = 50_000
# A motion has escaped if its half range is above this, relative to that of the cycle at the fold.
_ESCAPE_RATIO: Final = 0.7
# Parameter sets in a batch: bounds its memory.
_CHUNK_SIZE: Final = 256
_X, _Y = 0, 2


def escape_offsets(
    system: System,
    columns: Mapping[str, Floats],
    fold_half_ranges: Floats,
    *,
    work: Progress,
) -> Floats:
    """Least displacements from rest that escape, m, to 2 %; NaN if none of those tested escapes.

    `columns` are the parameters that vary, and `fold_half_ranges` the half ranges, m, of the cycles
    at the folds, each with an element per parameter set.
    """
    offsets = np.full(fold_half_ranges.size, np.nan)
    for begin in range(0, fold_half_ranges.size, _CHUNK_SIZE):
        work.report(begin / fold_half_ranges.size)
        rows = slice(begin, begin + _CHUNK_SIZE)
        chunk_columns = {name: column[rows] for name, column in columns.items()}
        offsets[rows] = _Chunk(system, chunk_columns, fold_half_ranges[rows]).escape_offsets()
    return offsets


class _Chunk:
    # Parameter sets whose motions are computed together.

    def __init__(
        self, system: System, columns: Mapping[str, Floats], fold_half_ranges: Floats
    ) -> None:
        self._system, self._columns, self._fold_half_ranges = system, columns, fold_half_ranges
        systems = [
            system.with_values({name: float(column[row]) for name, column in columns.items()})
            for row in range(fold_half_ranges.size)
        ]
        equilibria = [equilibrium(system_of_row) for system_of_row in systems]
        self._rest_x = np.array([point.x for point in equilibria])
        self._rest_y = np.array([point.y for point in equilibria])
        parameter_sets = (system_of_row.parameters for system_of_row in systems)
        # The mean of the decay rates c1/(2 m) of x and c2/(2 m) of y.
        decay_rates = [(p.c1 + p.c2) / (4.0 * p.m) for p in parameter_sets]
        self._duration = float(_DECAY_TIMES / min(decay_rates))

    def escape_offsets(self) -> Floats:
        upward, downward = (self._offsets_in_direction(direction) for direction in (1.0, -1.0))
        return np.fmin(upward, downward)

    def _offsets_in_direction(self, direction: float) -> Floats:
        # Least displacements upwards (1) or downwards (-1) that escape, NaN without one.
        count = self._fold_half_ranges.size
        ratios = np.geomspace(_LEAST_RATIO, _GREATEST_RATIO, _RATIO_COUNT)
        offsets = np.outer(self._fold_half_ranges, ratios)
        rows = np.repeat(np.arange(count), ratios.size)
        escapes = self._escape_flags(rows, direction * offsets.ravel()).reshape(offsets.shape)
        escaping_rows = np.flatnonzero(escapes.any(axis=1))
        first = escapes.argmax(axis=1)[escaping_rows]
        # Bisect between the first displacement that escapes and the one before it, which returns.
        # Before the first column there is a column of zeros, so that indices shift by one.
        escaping = offsets[escaping_rows, first]
        previous_offsets = np.pad(offsets, ((0, 0), (1, 0)))
        returning = previous_offsets[escaping_rows, first]
        for _ in range(_BISECTIONS):
            middle = 0.5 * (returning + escaping)
            escapes = self._escape_flags(escaping_rows, direction * middle)
            returning = np.where(escapes, returning, middle)
            escaping = np.where(escapes, middle, escaping)
        least_offsets = np.full(count, np.nan)
        least_offsets[escaping_rows] = escaping
        return least_offsets

    def _escape_flags(self, rows: NDArray[np.int64], offsets: Floats) -> NDArray[np.bool_]:
        # Whether motions from rest escape, at displacements of the parameter sets in these rows.
        starts = np.zeros((rows.size, 4))
        starts[:, _X] = self._rest_x[rows]
        starts[:, _Y] = self._rest_y[rows] + offsets
        if not rows.size:
            return np.zeros(0, dtype=bool)
        run = simulate_batch(
            {name: column[rows] for name, column in self._columns.items()},
            base=self._system.parameters,
            t_end=self._duration,
            tol=_TOL,
            separation=self._system.separation,
            start=starts,
            require={"steady"},
            max_steps=_MAX_STEPS,
        )
        is_large = run.steady.y_half_range > _ESCAPE_RATIO * self._fold_half_ranges[rows]
        escapes: NDArray[np.bool_] = is_large | (run.status == Status.OVERFLOW)
        return escapes

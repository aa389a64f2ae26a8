"""Least vertical displacements from rest that lead to another attractor, of many sets."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import simulate_batch
from fivtui.kernel import Status
from fivtui.model import Progress, System, equilibrium

Floats = NDArray[np.float64]

# Tested displacements, relative to the half range at the fold: least, greatest, and their count.
_LEAST_RATIO: Final = 0.02
_GREATEST_RATIO: Final = 5.0
_RATIO_COUNT: Final = 14
_BISECTIONS: Final = 5
# Duration of motions in decay times of the slider without friction: long, as motions leave the
# cycles on the boundary of the basins slowly.
_DECAY_TIMES: Final = 12.0
_TOL: Final = 1e-6
_MOST_STEPS: Final = 50_000
# Ratio of a half range to that at the fold above which a motion has escaped.
_ESCAPE_RATIO: Final = 0.7
# Parameter sets in a batch.
_CHUNK_SIZE: Final = 256


def escape_offsets(
    system: System,
    columns: Mapping[str, Floats],
    fold_sizes: Floats,
    *,
    work: Progress,
) -> Floats:
    """Least displacements from rest that escape, to 2 %; NaN if none of those tested escapes."""
    offsets = np.full(fold_sizes.size, np.nan)
    for begin in range(0, fold_sizes.size, _CHUNK_SIZE):
        work.report(begin / fold_sizes.size)
        part = slice(begin, begin + _CHUNK_SIZE)
        chunk_columns = {name: column[part] for name, column in columns.items()}
        offsets[part] = _Chunk(system, chunk_columns, fold_sizes[part]).escape_offsets()
    return offsets


class _Chunk:
    # Parameter sets whose motions are computed in two batches, displaced upwards and downwards.

    def __init__(self, system: System, columns: Mapping[str, Floats], fold_sizes: Floats) -> None:
        self._system, self._columns, self._fold_sizes = system, columns, fold_sizes
        sets = [
            system.with_values({name: float(column[index]) for name, column in columns.items()})
            for index in range(fold_sizes.size)
        ]
        equilibria = [equilibrium(changed) for changed in sets]
        self._rest = np.array([(point.x, point.y) for point in equilibria])
        rates = [(p.c1 + p.c2) / (4.0 * p.m) for p in (changed.parameters for changed in sets)]
        self._horizon = float(_DECAY_TIMES / min(rates))

    def escape_offsets(self) -> Floats:
        ratios = np.geomspace(_LEAST_RATIO, _GREATEST_RATIO, _RATIO_COUNT)
        offsets_by_side = [self._offsets_on_side(sign, ratios) for sign in (1.0, -1.0)]
        return np.fmin(*offsets_by_side)

    def _offsets_on_side(self, sign: float, ratios: Floats) -> Floats:
        count = self._fold_sizes.size
        sets = np.repeat(np.arange(count), ratios.size)
        offsets = np.outer(self._fold_sizes, ratios)
        escaped = self._escape_flags(sets, sign * offsets.ravel()).reshape(offsets.shape)
        first = escaped.argmax(axis=1)
        escaping = np.flatnonzero(escaped.any(axis=1))
        outside = offsets[escaping, first[escaping]]
        inside = np.where(
            first[escaping] > 0, offsets[escaping, np.maximum(first[escaping] - 1, 0)], 0.0
        )
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + outside)
            escapes = self._escape_flags(escaping, sign * middle)
            inside, outside = np.where(escapes, inside, middle), np.where(escapes, middle, outside)
        least_offsets = np.full(count, np.nan)
        least_offsets[escaping] = outside
        return least_offsets

    def _escape_flags(self, sets: NDArray[np.int64], offsets: Floats) -> NDArray[np.bool_]:
        starts = np.zeros((sets.size, 4))
        starts[:, 0] = self._rest[sets, 0]
        starts[:, 2] = self._rest[sets, 1] + offsets
        if not sets.size:
            return np.zeros(0, dtype=bool)
        run = simulate_batch(
            {name: column[sets] for name, column in self._columns.items()},
            base=self._system.parameters,
            t_end=self._horizon,
            tol=_TOL,
            separation=self._system.separation,
            start=starts,
            require={"steady"},
            max_steps=_MOST_STEPS,
        )
        is_large = run.steady.y_half_range > _ESCAPE_RATIO * self._fold_sizes[sets]
        escaped: NDArray[np.bool_] = is_large | (run.status == Status.OVERFLOW)
        return escaped

"""Least vertical displacements from rest that lead to another attractor, for many sets."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import simulate_batch
from fivtui.kernel import Status
from fivtui.model import Progress, System, equilibrium

Floats = NDArray[np.float64]

# Displacements to try, in half peak-to-peak of the cycle at the fold: lowest, highest, count.
_SMALLEST: Final = 0.02
_LARGEST: Final = 5.0
_RUNGS: Final = 14
_HALVINGS: Final = 5
# Horizon in decay times of the slider without friction: the cycles that separate the basins repel
# slowly.
_DECAYS: Final = 12.0
_TOL: Final = 1e-6
_MOST_STEPS: Final = 50_000
# Late amplitude above which a motion has escaped, relative to the fold's.
_ESCAPED: Final = 0.7
# Parameter sets in a batch.
_CHUNK: Final = 256


def escape_offsets(
    system: System,
    columns: Mapping[str, Floats],
    sizes: Floats,
    *,
    work: Progress,
) -> Floats:
    """The least displacement from rest, up or down, that escapes, to 2 %; NaN without one."""
    offsets = np.full(sizes.size, np.nan)
    for begin in range(0, sizes.size, _CHUNK):
        work.report(begin / sizes.size)
        part = slice(begin, begin + _CHUNK)
        chosen = {name: column[part] for name, column in columns.items()}
        offsets[part] = _Chunk(system, chosen, sizes[part]).escape_offsets()
    return offsets


class _Chunk:
    # Parameter sets whose slider is displaced upwards and downwards in one batch each.

    def __init__(self, system: System, columns: Mapping[str, Floats], sizes: Floats) -> None:
        self._system, self._columns, self._sizes = system, columns, sizes
        sets = [
            system.with_values({name: float(column[index]) for name, column in columns.items()})
            for index in range(sizes.size)
        ]
        points = [equilibrium(changed) for changed in sets]
        self._rest = np.array([(point.x, point.y) for point in points])
        decay = [(p.c1 + p.c2) / (4.0 * p.m) for p in (changed.parameters for changed in sets)]
        self._horizon = float(_DECAYS / min(decay))

    def escape_offsets(self) -> Floats:
        ladder = np.geomspace(_SMALLEST, _LARGEST, _RUNGS)
        sides = [self._offsets_on_side(sign, ladder) for sign in (1.0, -1.0)]
        return np.fmin(*sides)

    def _offsets_on_side(self, sign: float, ladder: Floats) -> Floats:
        count = self._sizes.size
        sets = np.repeat(np.arange(count), ladder.size)
        offsets = np.outer(self._sizes, ladder)
        escaped = self._escapes(sets, sign * offsets.ravel()).reshape(offsets.shape)
        first = escaped.argmax(axis=1)
        escaping = np.flatnonzero(escaped.any(axis=1))
        outside = offsets[escaping, first[escaping]]
        inside = np.where(
            first[escaping] > 0, offsets[escaping, np.maximum(first[escaping] - 1, 0)], 0.0
        )
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            out = self._escapes(escaping, sign * middle)
            inside, outside = np.where(out, inside, middle), np.where(out, middle, outside)
        offset_at_set = np.full(count, np.nan)
        offset_at_set[escaping] = outside
        return offset_at_set

    def _escapes(self, sets: NDArray[np.int64], offsets: Floats) -> NDArray[np.bool_]:
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
        late = run.steady.y_half_range > _ESCAPED * self._sizes[sets]
        escaped: NDArray[np.bool_] = late | (run.status == Status.OVERFLOW)
        return escaped

"""Least vertical displacements from rest that end on another attractor, of many sets at once."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.batch import simulate_batch
from fivtui.kernel import Status
from fivtui.model import Progress, System, equilibrium

Floats = NDArray[np.float64]

# Displacements that are tried, in half peak-to-peak of the cycle at the fold: from, to, how many.
_SMALLEST: Final = 0.02
_LARGEST: Final = 5.0
_RUNGS: Final = 14
_HALVINGS: Final = 5
# Horizon in decay times of the slider without friction: the cycles that separate the two ends
# repel slowly.
_DECAYS: Final = 12.0
_TOL: Final = 1e-6
_MOST_STEPS: Final = 50_000
# A motion with more than this part of the fold's amplitude late in its run has escaped.
_ESCAPED: Final = 0.7
# Parameter sets of a batch.
_CHUNK: Final = 256


def escape_offsets(
    system: System,
    columns: Mapping[str, Floats],
    sizes: Floats,
    *,
    work: Progress,
) -> Floats:
    """The least displacement from rest, up or down, that escapes, to 2 %; NaN where none does."""
    found = np.full(sizes.size, np.nan)
    for begin in range(0, sizes.size, _CHUNK):
        work.report(begin / sizes.size)
        part = slice(begin, begin + _CHUNK)
        chosen = {name: column[part] for name, column in columns.items()}
        found[part] = _Chunk(system, chosen, sizes[part]).least()
    return found


class _Chunk:
    # Parameter sets, each with a displacement upwards and one downwards.

    def __init__(self, system: System, columns: Mapping[str, Floats], sizes: Floats) -> None:
        self._system, self._columns, self._sizes = system, columns, sizes
        sets = [
            system.with_values({name: float(column[place]) for name, column in columns.items()})
            for place in range(sizes.size)
        ]
        points = [equilibrium(one) for one in sets]
        self._rest = np.array([(point.x, point.y) for point in points])
        decay = [(p.c1 + p.c2) / (4.0 * p.m) for p in (one.parameters for one in sets)]
        self._horizon = float(_DECAYS / min(decay))

    def least(self) -> Floats:
        ladder = np.geomspace(_SMALLEST, _LARGEST, _RUNGS)
        sides = [self._side(sign, ladder) for sign in (1.0, -1.0)]
        return np.fmin(*sides)

    def _side(self, sign: float, ladder: Floats) -> Floats:
        count = self._sizes.size
        every = np.repeat(np.arange(count), ladder.size)
        offsets = np.outer(self._sizes, ladder)
        escaped = self._escape(every, sign * offsets.ravel()).reshape(offsets.shape)
        first = escaped.argmax(axis=1)
        some = np.flatnonzero(escaped.any(axis=1))
        outside = offsets[some, first[some]]
        inside = np.where(first[some] > 0, offsets[some, np.maximum(first[some] - 1, 0)], 0.0)
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            out = self._escape(some, sign * middle)
            inside, outside = np.where(out, inside, middle), np.where(out, middle, outside)
        found = np.full(count, np.nan)
        found[some] = outside
        return found

    def _escape(self, places: NDArray[np.int64], offsets: Floats) -> NDArray[np.bool_]:
        starts = np.zeros((places.size, 4))
        starts[:, 0] = self._rest[places, 0]
        starts[:, 2] = self._rest[places, 1] + offsets
        if not places.size:
            return np.zeros(0, dtype=bool)
        run = simulate_batch(
            {name: column[places] for name, column in self._columns.items()},
            base=self._system.parameters,
            t_end=self._horizon,
            tol=_TOL,
            separation=self._system.separation,
            start=starts,
            require={"steady"},
            max_steps=_MOST_STEPS,
        )
        late = run.steady.y_half_range > _ESCAPED * self._sizes[places]
        escaped: NDArray[np.bool_] = late | (run.status == Status.OVERFLOW)
        return escaped

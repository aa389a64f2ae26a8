"""Exact extremes of a linear motion by branch and bound over time.

A span is searched only if its bounds exceed the extremes so far. With growth or decay that leaves a
few periods for any horizon. The bounds need no eigenvectors.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Progress
from fivtui.transient.extremes import Extremes

from .exponential import DEGREE, LinearMotion

FloatArray = NDArray[np.float64]
Spans = list[tuple[int, FloatArray]]

# Quantities to maximise: x, −x, y, −y and ẋ/ω.
_SOUGHT: Final = np.array(
    [[1.0, 0, 0, 0], [-1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0]]
)
_CHUNK: Final = 1 << 15
# Bounds are sampled at intervals of the base span / 2^_REFINEMENT, in chunks of _SAMPLES.
_REFINEMENT: Final = 6
_SAMPLES: Final = 1 << 10
# Relative rounding of a state, and the largest relative uncertainty of an extreme.
_NOISE: Final = 2.0**-46
_DOUBT: Final = 2.0**-44


class Search:
    """Search for the extremes of a linear motion up to a horizon in at most `max_steps` spans."""

    def __init__(self, motion: LinearMotion, t_end: float, max_steps: int, work: Progress) -> None:
        self._motion, self._t_end, self._max_steps, self._work = motion, t_end, max_steps, work
        self._steps, self._searched = 0, 0.0
        self._best = np.full(5, -np.inf)
        self._rest = _SOUGHT @ motion.rest
        spans = motion.spans[: motion.base + _REFINEMENT, None, None]
        # Bounds of the distance from rest per unit of z − rest, and from the chord per unit of ż.
        self._reach = self._greatest(_SOUGHT, motion.spans.size)
        bend = self._greatest(_SOUGHT @ motion.matrix, len(spans))
        self._bend = bend * spans[: len(bend)] ** 2 / 8.0

    def _greatest(self, rows: FloatArray, levels: int) -> FloatArray:
        # Bounds, per span, of |rows exp(A s)| over it. From the level `fine` on they are sampled at
        # multiples of a span; the growth over one such span covers the times between.
        motion = self._motion
        fine = motion.base - _REFINEMENT
        growth, term = np.eye(4)[None], np.eye(4)
        scaled = np.abs(motion.matrix) * motion.spans[fine]
        shares = (motion.spans[: fine + 1] / motion.spans[fine])[:, None, None]
        for n in range(1, DEGREE):
            term = term @ scaled / n
            growth = growth + term * shares**n
        bounds = list(np.abs(rows) @ growth)
        powers, within = np.eye(4)[None], None
        with np.errstate(over="ignore", invalid="ignore"):
            for exponential in motion.exponentials[fine : levels - 1]:
                if len(powers) == _SAMPLES:
                    powers, within = np.eye(4)[None], bounds[-1]
                powers = np.concatenate([powers, powers @ exponential])
                if within is None:
                    sampled = np.abs(rows @ powers) @ growth[-1]
                else:
                    sampled = within @ np.abs(powers)
                bounds.append(sampled.max(axis=0))
        return np.array(bounds)

    def over(self, spans: Spans, end: FloatArray) -> Extremes:
        """Extremes over consecutive spans and those before.

        `spans` has the index of every span and the state, shape (1, 4), at its start; `end` is the
        state after the last. Raises `ComputationError` if too many spans must be looked at, and
        `Cancelled`.
        """
        starts = [z for _, z in spans]
        self._update_best(np.concatenate([*starts, end]) @ _SOUGHT.T)
        waiting = spans.copy()
        while waiting:
            level, z = waiting.pop()
            if len(z) > _CHUNK:
                waiting += [(level, part) for part in np.array_split(z, len(z) // _CHUNK + 1)]
                continue
            promising = self._promising(level, z)
            if len(promising) and level > 0:
                middle = self._motion.after(promising, level - 1)
                self._update_best(middle @ _SOUGHT.T)
                waiting.append((level - 1, np.concatenate([promising, middle])))
                rest = len(z) - len(promising)
            else:
                rest = len(z)
            self._account(len(z), rest * float(self._motion.spans[level]))
        x_max, x_low, y_max, y_low, fastest = (self._best + 0.0).tolist()
        vx_max = float(self._motion.states(np.array([0.0, fastest, 0.0, 0.0]))[1])
        return Extremes(0.0 - x_low, 0.0 - y_low, x_max, y_max, vx_max)

    def _update_best(self, values: FloatArray) -> None:
        self._best = np.maximum(self._best, values.max(axis=0))

    def _promising(self, level: int, z: FloatArray) -> FloatArray:
        # States whose spans may exceed the extremes so far by more than rounding.
        motion, best = self._motion, self._best
        size = max(float(np.abs(best).max()), float(np.abs(self._rest).max()))
        with np.errstate(over="ignore", invalid="ignore"):
            reach = self._reach[level].T
            noise = _NOISE * (np.abs(z) + np.abs(motion.rest))
            doubt = np.minimum(noise @ reach, _DOUBT * size)
            bound = self._rest + np.abs(z - motion.rest) @ reach
            if level < len(self._bend):
                ends = np.maximum(z @ _SOUGHT.T, motion.after(z, level) @ _SOUGHT.T)
                bent = np.abs(motion.velocity(z)) @ self._bend[level].T
                bound = np.minimum(bound, ends + bent)
        # A bound of NaN excludes nothing.
        promising: FloatArray = z[~np.all(bound <= best + doubt, axis=1)]
        return promising

    def _account(self, steps: int, seconds: float) -> None:
        self._steps += steps
        self._searched += seconds
        self._work.report(min(self._searched / self._t_end, 1.0))
        if self._steps > self._max_steps:
            raise ComputationError(
                f"the extremes are not found in {self._max_steps} spans of time",
                "use a shorter horizon, or damping that lets the motion settle",
            )

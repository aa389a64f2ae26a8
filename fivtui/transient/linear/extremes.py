"""Exact extremes of a linear motion by branch and bound over time.

A span of time is halved and searched only if its bounds exceed the extremes so far. If the motion
grows or decays, few periods are searched for any horizon. The bounds need no eigenvectors.

Spans are powers of two in seconds; the level of a span is its index, from the shortest. The base
span is the longest over which a Taylor series gives the motion.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Progress
from fivtui.taylor import Extremes

from .exponential import DEGREE, LinearMotion

FloatArray = NDArray[np.float64]
# Levels of spans, and states of the motion at the starts of spans of this level, shape (n, 4).
Spans = list[tuple[int, FloatArray]]

# Quantities to maximise, as rows that multiply a state: x, −x, y, −y and ẋ/ω.
_QUANTITIES: Final = np.array(
    [[1.0, 0, 0, 0], [-1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0]]
)
# Number of states that are searched together, to limit memory.
_MAX_STATES: Final = 1 << 15
# Bounds are computed at intervals of the base span / 2^_REFINEMENT, in chunks of this number.
_REFINEMENT: Final = 6
_BOUNDS_PER_CHUNK: Final = 1 << 10
# Relative rounding error of a state, and relative tolerance of an extreme.
_STATE_ROUNDING: Final = 2.0**-46
_EXTREME_TOLERANCE: Final = 2.0**-44


class Search:
    """Search for the extremes of a linear motion up to a horizon in at most `max_steps` spans."""

    def __init__(self, motion: LinearMotion, t_end: float, max_steps: int, work: Progress) -> None:
        self._motion, self._t_end, self._max_steps, self._work = motion, t_end, max_steps, work
        self._span_count, self._finished_time = 0, 0.0
        self._extremes = np.full(5, -np.inf)
        self._rest_values = _QUANTITIES @ motion.rest
        # Chords are used only over spans up to about the base span, because the bound of the
        # distance from them grows as the square of the span.
        spans = motion.spans[: motion.base + _REFINEMENT, None, None]
        # Arrays by level, quantity and component of the state, shape (levels, 5, 4). Multiplied by
        # |z − rest|, `_distance_bounds` bound the distance of each quantity from its value at rest.
        # Multiplied by |ż|, `_chord_bounds` bound its distance from the chord.
        self._distance_bounds = self._row_bounds(_QUANTITIES, motion.spans.size)
        chord_bounds = self._row_bounds(_QUANTITIES @ motion.matrix, len(spans))
        self._chord_bounds = chord_bounds * spans[: len(chord_bounds)] ** 2 / 8.0

    def _row_bounds(self, rows: FloatArray, levels: int) -> FloatArray:
        # Bounds of |rows exp(A s)| over the span of each level. Up to `fine_level` the growth
        # exp(|A| s) bounds exp(A s). Above, exp(A s) is computed at multiples of the span of
        # `fine_level`, and the growth over that span bounds it between two multiples.
        motion = self._motion
        fine_level = motion.base - _REFINEMENT
        growth, term = np.eye(4)[None], np.eye(4)
        scaled_matrix = np.abs(motion.matrix) * motion.spans[fine_level]
        span_ratios = (motion.spans[: fine_level + 1] / motion.spans[fine_level])[:, None, None]
        for n in range(1, DEGREE):
            term = term @ scaled_matrix / n
            growth = growth + term * span_ratios**n
        bounds = list(np.abs(rows) @ growth)
        # Powers of exp(A s) for s = span of `fine_level`, within the span of the level. After
        # `_BOUNDS_PER_CHUNK` they begin anew, with the powers of exp(A S) for the span S reached.
        # Then |rows exp(A (r + n S))| ≤ (bound of |rows exp(A r)| for r ≤ S) · |exp(A S)ⁿ|.
        powers, previous_bounds = np.eye(4)[None], None
        with np.errstate(over="ignore", invalid="ignore"):
            for exponential in motion.exponentials[fine_level : levels - 1]:
                if len(powers) == _BOUNDS_PER_CHUNK:
                    powers, previous_bounds = np.eye(4)[None], bounds[-1]
                powers = np.concatenate([powers, powers @ exponential])
                if previous_bounds is None:
                    sampled = np.abs(rows @ powers) @ growth[-1]
                else:
                    sampled = previous_bounds @ np.abs(powers)
                bounds.append(sampled.max(axis=0))
        return np.array(bounds)

    def find_extremes(self, spans: Spans, end: FloatArray) -> Extremes:
        """Extremes over consecutive spans and those before.

        `spans` has the level of every span and the state, shape (1, 4), at its start; `end` is the
        state after the last span. Raises `ComputationError` if more than `max_steps` spans are
        searched, and `Cancelled`.
        """
        starts = [z for _, z in spans]
        self._update_extremes(np.concatenate([*starts, end]) @ _QUANTITIES.T)
        queue = spans.copy()
        while queue:
            level, z = queue.pop()
            if len(z) > _MAX_STATES:
                queue += [(level, chunk) for chunk in np.array_split(z, len(z) // _MAX_STATES + 1)]
                continue
            candidates = self._candidate_states(level, z)
            if len(candidates) and level > 0:
                middle = self._motion.states_after(candidates, level - 1)
                self._update_extremes(middle @ _QUANTITIES.T)
                queue.append((level - 1, np.concatenate([candidates, middle])))
                finished_count = len(z) - len(candidates)
            else:
                finished_count = len(z)
            self._count_searched(len(z), finished_count * float(self._motion.spans[level]))
        # Adding to 0.0 and subtracting from it avoids −0.0.
        x_max, minus_x_min, y_max, minus_y_min, scaled_vx_max = (self._extremes + 0.0).tolist()
        vx_max = float(self._motion.states(np.array([0.0, scaled_vx_max, 0.0, 0.0]))[1])
        return Extremes(0.0 - minus_x_min, 0.0 - minus_y_min, x_max, y_max, vx_max)

    def _update_extremes(self, values: FloatArray) -> None:
        self._extremes = np.maximum(self._extremes, values.max(axis=0))

    def _candidate_states(self, level: int, z: FloatArray) -> FloatArray:
        # States from which the motion may exceed the extremes so far within the span of a level.
        motion, extremes = self._motion, self._extremes
        scale = max(float(np.abs(extremes).max()), float(np.abs(self._rest_values).max()))
        with np.errstate(over="ignore", invalid="ignore"):
            distance_bounds = self._distance_bounds[level].T
            rounding = _STATE_ROUNDING * (np.abs(z) + np.abs(motion.rest))
            # Exceeding an extreme by less than the rounding error does not count. The bound of the
            # rounding error may be large if the motion grows; the tolerance limits it.
            tolerance = np.minimum(rounding @ distance_bounds, _EXTREME_TOLERANCE * scale)
            bounds = self._rest_values + np.abs(z - motion.rest) @ distance_bounds
            if level < len(self._chord_bounds):
                chord_maxima = np.maximum(
                    z @ _QUANTITIES.T, motion.states_after(z, level) @ _QUANTITIES.T
                )
                chord_distances = np.abs(motion.velocity(z)) @ self._chord_bounds[level].T
                bounds = np.minimum(bounds, chord_maxima + chord_distances)
        # Spans with bounds of NaN are searched.
        candidates: FloatArray = z[~np.all(bounds <= extremes + tolerance, axis=1)]
        return candidates

    def _count_searched(self, spans: int, finished_time: float) -> None:
        # Count spans, and the time, s, that needs no further search; report progress.
        self._span_count += spans
        self._finished_time += finished_time
        self._work.report(min(self._finished_time / self._t_end, 1.0))
        if self._span_count > self._max_steps:
            raise ComputationError(
                f"the search for extremes needs more than {self._max_steps} spans of time",
                "use a shorter horizon, or damping that lets the motion settle",
            )

"""Running extremes of the motion: exact extrema of its polynomials, not of samples.

A segment is the motion over one step, as polynomials on [0, 1] in time relative to its duration.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import mul

from .polynomial import derivative, minimum_maximum, restrict
from .segment import Segment


@dataclass(slots=True)
class Extremes:
    """Least and greatest x and y, m, and greatest ẋ, m/s, over the segments included so far.

    Without a belt speed, the model assumes that the belt is faster than the slider: it is valid for
    belt speeds above the greatest ẋ.
    """

    x_min: float = math.inf
    y_min: float = math.inf
    x_max: float = -math.inf
    y_max: float = -math.inf
    vx_max: float = -math.inf

    def include(self, segment: Segment) -> None:
        """Include a segment."""
        self._include(segment.x, segment.y, segment.final[:3], segment.duration)

    def include_part(self, segment: Segment, start: float, end: float) -> None:
        """Include the part of a segment between two times, s."""
        low, high = max(segment.fraction(start), 0.0), min(segment.fraction(end), 1.0)
        if low < high:
            x, y = restrict(segment.x, low, high), restrict(segment.y, low, high)
            duration = segment.duration * (high - low)
            # The value of a polynomial at 1 is the sum of its coefficients.
            self._include(x, y, (sum(x), sum(derivative(x)) / duration, sum(y)), duration)

    def _include(
        self,
        x: Sequence[float],
        y: Sequence[float],
        ends: tuple[float, float, float],
        duration: float,
    ) -> None:
        # `ends` are x, ẋ and y at the end.
        # On [0, 1] a polynomial differs from its chord by at most max|second derivative|/8. If its
        # ends plus this margin cannot exceed an extreme so far, skip the roots of its derivative.
        x_end, vx_end, y_end = ends
        weights, vx_weights = _margin_weights(len(x))
        x_sizes = list(map(abs, x))
        margin = sum(map(mul, x_sizes, weights))
        if max(x[0], x_end) + margin > self.x_max or min(x[0], x_end) - margin < self.x_min:
            least, greatest = minimum_maximum(x)
            self.x_min, self.x_max = min(self.x_min, least), max(self.x_max, greatest)
        margin = sum(map(mul, map(abs, y), weights))
        if max(y[0], y_end) + margin > self.y_max or min(y[0], y_end) - margin < self.y_min:
            least, greatest = minimum_maximum(y)
            self.y_min, self.y_max = min(self.y_min, least), max(self.y_max, greatest)
        margin = sum(map(mul, x_sizes, vx_weights))
        if max(x[1], vx_end * duration) + margin > self.vx_max * duration:
            self.vx_max = max(self.vx_max, minimum_maximum(derivative(x))[1] / duration)


@lru_cache(maxsize=64)
def _margin_weights(size: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    # Weights of |coefficients| that bound |second derivative|/8 of a polynomial on [0, 1], and the
    # same for its derivative.
    return (
        tuple(n * (n - 1) / 8.0 for n in range(size)),
        tuple(n * (n - 1) * (n - 2) / 8.0 for n in range(size)),
    )

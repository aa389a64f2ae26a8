"""Running extremes of the motion: exact extrema of the polynomials, not of samples."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import mul

from fivtui.model import State
from fivtui.taylor import Segment, derivative, minimum_maximum, restricted


@dataclass(slots=True)
class Extremes:
    """Least and greatest x and y, m, and greatest ẋ, m/s, over the segments included so far.

    The greatest ẋ is the least belt speed for which the model is valid.
    """

    x_min: float = math.inf
    y_min: float = math.inf
    x_max: float = -math.inf
    y_max: float = -math.inf
    vx_max: float = -math.inf

    def include(self, segment: Segment) -> None:
        """Include a segment."""
        self._include(segment.x, segment.y, segment.final, segment.duration)

    def include_part(self, segment: Segment, start: float, end: float) -> None:
        """Include the part of a segment between two times, s."""
        low, high = max(segment.fraction(start), 0.0), min(segment.fraction(end), 1.0)
        if low < high:
            x, y = restricted(segment.x, low, high), restricted(segment.y, low, high)
            duration = segment.duration * (high - low)
            final = (sum(x), sum(derivative(x)) / duration, sum(y), 0.0)
            self._include(x, y, final, duration)

    def _include(
        self,
        x: Sequence[float],
        y: Sequence[float],
        final: State,
        duration: float,
    ) -> None:
        # A function differs from its chord by at most max|second derivative|/8, so most segments
        # need no roots.
        x_end, vx_end, y_end, _ = final
        second, third = _weights(len(x))
        x_sizes = list(map(abs, x))
        bulge = sum(map(mul, x_sizes, second))
        if max(x[0], x_end) + bulge > self.x_max or min(x[0], x_end) - bulge < self.x_min:
            least, greatest = minimum_maximum(x)
            self.x_min, self.x_max = min(self.x_min, least), max(self.x_max, greatest)
        bulge = sum(map(mul, map(abs, y), second))
        if max(y[0], y_end) + bulge > self.y_max or min(y[0], y_end) - bulge < self.y_min:
            least, greatest = minimum_maximum(y)
            self.y_min, self.y_max = min(self.y_min, least), max(self.y_max, greatest)
        bulge = sum(map(mul, x_sizes, third))
        if max(x[1], vx_end * duration) + bulge > self.vx_max * duration:
            self.vx_max = max(self.vx_max, minimum_maximum(derivative(x))[1] / duration)


@lru_cache(maxsize=64)
def _weights(size: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    # Bounds of |second derivative|/8 of a polynomial on [0, 1], and of its derivative.
    return (
        tuple(n * (n - 1) / 8.0 for n in range(size)),
        tuple(n * (n - 1) * (n - 2) / 8.0 for n in range(size)),
    )

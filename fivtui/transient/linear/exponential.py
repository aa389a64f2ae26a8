"""Motion of a linear scene by the matrix exponential, without stepping.

A contact without cubic term that never breaks leaves ż = A z + b. Over a span s

    z(t + s) = z(t) + Φ(s) (A z(t) + b),   Φ(s) = ∫₀ˢ exp(A r) dr,

whether or not A has all its eigenvectors (at the coalescence of two modes it has not). Φ is summed
as a Taylor series where it converges at once and doubled from there (scaling and squaring: Higham,
SIAM J. Matrix Anal. Appl. 26, 2005). Spans are powers of two in seconds, so that times are exact.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    Mode,
    Parameters,
    State,
    System,
    accelerations,
    jacobian,
    total_stiffness,
)
from fivtui.taylor import overflow_error

FloatArray = NDArray[np.float64]

# The series of a span of ‖A‖ s <= 2 ends with 2²⁶/26!, far below rounding.
_REACH: Final = 2.0
DEGREE: Final = 26
# Overflow threshold, with a margin for derivatives and bounds.
_LARGEST: Final = 1e300
# Number of halvings of the longest span. Over the shortest span a motion equals its chord to
# rounding.
DEEPEST: Final = 28


class LinearMotion:
    """The linear motion in contact, in (x, ẋ/ω, y, ẏ/ω) with ω² = (k1 + k2 + k3)/m."""

    def __init__(self, p: Parameters, t_end: float) -> None:
        frequency = math.sqrt(total_stiffness(p) / p.m)
        self._scale = np.array([1.0, frequency, 1.0, frequency])
        matrix = np.array(jacobian(p, 0.0, Mode.CONTACT)) * self._scale / self._scale[:, None]
        x, y = accelerations(p, (0.0, 0.0, 0.0, 0.0), Mode.CONTACT)
        self.load = np.array([0.0, x, 0.0, y]) / self._scale
        size = float(np.abs(matrix).sum(axis=1).max())
        self.matrix = matrix
        self.rest = np.linalg.solve(matrix, -self.load)
        # Longest span with ‖A‖ s between 1 and 2.
        longest = math.ldexp(1.0, math.frexp(_REACH / size)[1] - 1)
        self._double_spans(longest, t_end)

    def _double_spans(self, longest: float, t_end: float) -> None:
        short = longest * 2.0 ** np.arange(-DEEPEST, 1)
        identity = np.eye(4)
        scaled = self.matrix * short[:, None, None]
        total = np.broadcast_to(identity, scaled.shape)
        for n in range(DEGREE, 1, -1):
            total = identity + scaled @ total / n
        spans, integrals = list(short), list(total * short[:, None, None])
        exponentials = [identity + self.matrix @ integral for integral in integrals]
        while 2.0 * spans[-1] <= t_end:
            integral, exponential = integrals[-1], exponentials[-1]
            with np.errstate(over="ignore", invalid="ignore"):
                integral, exponential = integral + exponential @ integral, exponential @ exponential
            if not (np.all(np.isfinite(integral)) and np.all(np.isfinite(exponential))):
                break
            spans.append(2.0 * spans[-1])
            integrals.append(integral)
            exponentials.append(exponential)
        self.base = DEEPEST
        self.spans = np.array(spans)
        self.integrals, self.exponentials = np.array(integrals), np.array(exponentials)

    def scaled(self, state: State) -> FloatArray:
        """A state in the coordinates of this class, shape (4,)."""
        scaled: FloatArray = np.array(state) / self._scale
        return scaled

    def states(self, scaled: FloatArray) -> FloatArray:
        """States (x, ẋ, y, ẏ) in m and m/s, shape (n, 4), from those of this class."""
        states: FloatArray = scaled * self._scale
        return states

    def velocity(self, z: FloatArray) -> FloatArray:
        """ż of states, shape (n, 4)."""
        velocity: FloatArray = z @ self.matrix.T + self.load
        return velocity

    def after(self, z: FloatArray, level: int) -> FloatArray:
        """States, shape (n, 4), one span later; `level` is the index of the span."""
        later: FloatArray = z + self.velocity(z) @ self.integrals[level].T
        return later

    def at(self, z: FloatArray, times: FloatArray) -> FloatArray:
        """States, shape (n, 4), at times in s after the state `z`, not beyond an overflow."""
        states, remaining = np.tile(z, (times.size, 1)), times.copy()
        for level in range(self.spans.size - 1, self.base - 1, -1):
            span = self.spans[level]
            while np.any(far := remaining >= span):
                states[far] = self.after(states[far], level)
                remaining[far] -= span
        share, total = (remaining / self.spans[self.base])[:, None], np.zeros_like(states)
        for term in self.series(states)[::-1]:
            total = total * share + term
        return total

    def series(self, z: FloatArray) -> FloatArray:
        """Taylor coefficients of the motion from states, shape (27, n, 4).

        Of powers of (time since)/(base span), over which they converge.
        """
        span = self.spans[self.base]
        terms, scaled = [z, self.velocity(z) * span], self.matrix.T * span
        for n in range(2, DEGREE + 1):
            terms.append(terms[-1] @ scaled / n)
        return np.array(terms)


class Walk:
    """A walk along a linear motion in the longest spans that fit; it is at time `t`, state `z`."""

    def __init__(self, motion: LinearMotion, p: Parameters, start: State) -> None:
        self._motion, self._p = motion, p
        self.t, self.z = 0.0, motion.scaled(start)[None, :]

    def to(self, t_end: float) -> list[tuple[int, FloatArray]]:
        """Walk on to a time; returns the index of every span and the state (1, 4) at its start.

        Raises `ComputationError`, with the time, if the motion overflows on the way.
        """
        motion, remaining = self._motion, t_end - self.t
        walked, blocked = [], False
        for level in range(motion.spans.size - 1, -1, -1):
            span = float(motion.spans[level])
            while remaining >= span:
                with np.errstate(over="ignore", invalid="ignore"):
                    later = motion.after(self.z, level)
                    finite = self._finite(later)
                if not finite:
                    blocked = True
                    break
                walked.append((level, self.z))
                remaining, self.z = remaining - span, later
        if blocked:
            x, vx, y, vy = motion.states(self.z)[0].tolist()
            raise overflow_error(
                t_end - remaining, (x, vx, y, vy), System(self._p, separation=False)
            )
        # The remaining time is so short that the chord suffices.
        self.z = self.z + remaining * motion.velocity(self.z)
        self.t = t_end
        return walked

    def _finite(self, z: FloatArray) -> bool:
        force = self._p.k2 * z[0, 2]
        reached = (*self._motion.states(z)[0], *self._motion.velocity(z)[0], force)
        return all(abs(number) < _LARGEST for number in reached)

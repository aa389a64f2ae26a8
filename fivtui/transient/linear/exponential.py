"""Motion of a linear scene by the matrix exponential, without stepping.

In a contact without cubic term that never breaks, the state z obeys ż = A z + b. Over a span s

    z(t + s) = z(t) + Φ(s) (A z(t) + b),   Φ(s) = ∫₀ˢ exp(A r) dr,

also where A lacks eigenvectors, as at the coalescence of two modes. For short spans Φ is a Taylor
series; longer spans follow by doubling (scaling and squaring: Higham, SIAM J. Matrix Anal. Appl.
26, 2005). Spans are powers of two in seconds, so that times are exact. The level of a span is its
index, from the shortest; each span is twice the one before.
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

# Largest ‖A‖ s of a Taylor series of Φ, and its degree. The last term, 2²⁶/26!, is far below
# rounding.
_MAX_NORM: Final = 2.0
DEGREE: Final = 26
# Magnitude that counts as overflow. It is so far below the greatest float, 1.8e308, that bounds of
# extremes computed from smaller states are finite.
_OVERFLOW_LIMIT: Final = 1e300
# Number of halvings of the base span. Over the shortest span a motion equals its chord to rounding.
HALVINGS: Final = 28


class LinearMotion:
    """The linear motion in contact, in (x, ẋ/ω, y, ẏ/ω) with ω² = (k1 + k2 + k3)/m.

    k1, k2 and k3 are the stiffnesses of the horizontal, contact and coupling springs.

    Attributes
    ----------
    matrix, load : ndarray, shapes (4, 4) and (4,)
        A and b.
    rest : ndarray, shape (4,)
        Equilibrium, at which ż = 0.
    spans : ndarray, shape (n,)
        Lengths of the spans, s, ascending.
    base : int
        Level of the longest span whose Φ is a Taylor series.
    integrals, exponentials : ndarray, shape (n, 4, 4)
        Φ(s) and exp(A s) of the spans.
    """

    def __init__(self, p: Parameters, t_end: float) -> None:
        frequency = math.sqrt(total_stiffness(p) / p.m)
        self._scale = np.array([1.0, frequency, 1.0, frequency])
        matrix = np.array(jacobian(p, 0.0, Mode.CONTACT)) * self._scale / self._scale[:, None]
        x_acceleration, y_acceleration = accelerations(p, (0.0, 0.0, 0.0, 0.0), Mode.CONTACT)
        self.load = np.array([0.0, x_acceleration, 0.0, y_acceleration]) / self._scale
        norm = float(np.abs(matrix).sum(axis=1).max())
        self.matrix = matrix
        self.rest = np.linalg.solve(matrix, -self.load)
        # The longest span with ‖A‖ s between 1 and 2: frexp gives the exponent e for which
        # 2^(e − 1) ≤ _MAX_NORM/‖A‖ < 2^e.
        _, exponent = math.frexp(_MAX_NORM / norm)
        base_span = math.ldexp(1.0, exponent - 1)
        self._double_spans(base_span, t_end)

    def _double_spans(self, base_span: float, t_end: float) -> None:
        # Up to the base span Φ(s)/s = I + A s/2! + (A s)²/3! + …, by Horner's scheme.
        short_spans = base_span * 2.0 ** np.arange(-HALVINGS, 1)
        identity = np.eye(4)
        scaled_matrices = self.matrix * short_spans[:, None, None]
        series = np.broadcast_to(identity, scaled_matrices.shape)
        for n in range(DEGREE, 1, -1):
            series = identity + scaled_matrices @ series / n
        spans, integrals = list(short_spans), list(series * short_spans[:, None, None])
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
        self.base = HALVINGS
        self.spans = np.array(spans)
        self.integrals, self.exponentials = np.array(integrals), np.array(exponentials)

    def scaled_state(self, state: State) -> FloatArray:
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

    def states_after(self, z: FloatArray, level: int) -> FloatArray:
        """States, shape (n, 4), later by the span of a level."""
        later_states: FloatArray = z + self.velocity(z) @ self.integrals[level].T
        return later_states

    def states_at(self, z: FloatArray, times: FloatArray) -> FloatArray:
        """States, shape (n, 4), at times in s after the state `z`; the motion must not overflow."""
        # Advance by the longest spans that fit; the Taylor series covers the remaining time.
        states, remaining = np.tile(z, (times.size, 1)), times.copy()
        for level in range(self.spans.size - 1, self.base - 1, -1):
            span = self.spans[level]
            while np.any(unfinished := remaining >= span):
                states[unfinished] = self.states_after(states[unfinished], level)
                remaining[unfinished] -= span
        fraction = (remaining / self.spans[self.base])[:, None]
        final_states = np.zeros_like(states)
        for coefficients in self.series(states)[::-1]:
            final_states = final_states * fraction + coefficients
        return final_states

    def series(self, z: FloatArray) -> FloatArray:
        """Taylor coefficients of the motion from states, shape (27, n, 4).

        The variable is the time since a state divided by the base span.
        """
        span = self.spans[self.base]
        scaled_matrix = self.matrix.T * span
        coefficients = [z, self.velocity(z) * span]
        for n in range(2, DEGREE + 1):
            coefficients.append(coefficients[-1] @ scaled_matrix / n)
        return np.array(coefficients)


class Propagation:
    """Evaluation of a linear motion in the longest spans that fit, up to time `t` and state `z`."""

    def __init__(self, motion: LinearMotion, p: Parameters, start: State) -> None:
        self._motion, self._p = motion, p
        self.t, self.z = 0.0, motion.scaled_state(start)[None, :]

    def advance_to(self, t_end: float) -> list[tuple[int, FloatArray]]:
        """Advance to a time, s; return the level of every span and the state (1, 4) at its start.

        Raises `ComputationError`, with the time, if the motion overflows before.
        """
        motion, remaining = self._motion, t_end - self.t
        spans, overflows = [], False
        for level in range(motion.spans.size - 1, -1, -1):
            span = float(motion.spans[level])
            while remaining >= span:
                with np.errstate(over="ignore", invalid="ignore"):
                    end_state = motion.states_after(self.z, level)
                    is_finite = self._is_finite(end_state)
                if not is_finite:
                    # Shorter spans then approach the time of the overflow.
                    overflows = True
                    break
                spans.append((level, self.z))
                remaining, self.z = remaining - span, end_state
        if overflows:
            x, vx, y, vy = motion.states(self.z)[0].tolist()
            raise overflow_error(
                t_end - remaining, (x, vx, y, vy), System(self._p, separation=False)
            )
        # The remaining time is so short that the chord suffices.
        self.z = self.z + remaining * motion.velocity(self.z)
        self.t = t_end
        return spans

    def _is_finite(self, z: FloatArray) -> bool:
        # Whether a state, its derivative and its contact force are below the overflow limit.
        force = self._p.k2 * z[0, 2]
        values = (*self._motion.states(z)[0], *self._motion.velocity(z)[0], force)
        return all(abs(number) < _OVERFLOW_LIMIT for number in values)

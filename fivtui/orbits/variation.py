"""The flow over a time and its derivative by the start: variational equations on Taylor series.

A small deviation δz = (δx, δy) from a motion in contact obeys, with the symbols of `taylor.series`,

    δz̈ = a δx + b δy + C δż − 3 d y² δy

in which y is the polynomial of a segment of the Taylor integrator: over a piece of the segment its
coefficients follow by the same kind of recurrence. Both right-hand sides agree at y = 0, hence the
saltation matrix at a switch is the identity, and the derivative of the flow is the product of those
of the pieces.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Parameters, State, accelerations, mode_of
from fivtui.taylor import Constants, Segment, TaylorStepper, constants, restricted, state_function

FloatArray = NDArray[np.float64]

_SIZE: Final = 4
_LOCAL_TOLERANCE: Final = 1e-16
# Order of the series of deviations over a piece: 1/20! is below rounding.
_DEGREE: Final = 20
_MAX_SEGMENTS: Final = 200_000
_PIECES_AT_ONCE: Final = 1024


class _Piece(NamedTuple):
    """A part of a segment: its constants, y as a polynomial on [0, 1], and its length, s."""

    c: Constants
    y: list[float]
    duration: float


@dataclass(frozen=True, slots=True)
class Flow:
    """Final state of the flow, its time derivative, and its derivative by the start (4 × 4)."""

    final: State
    velocity: FloatArray
    derivative: FloatArray


def flow(p: Parameters, start: State, duration: float, *, separation: bool = True) -> Flow:
    """Final state and fundamental matrix after a positive duration in s.

    The determinant of the matrix is exp(−(c1 + c2)/m · duration). Raises `ComputationError` if the
    motion cannot be followed.
    """
    stepper = TaylorStepper(p, start, separation=separation, tol=_LOCAL_TOLERANCE)
    total, state = np.eye(_SIZE), start
    pieces: list[_Piece] = []
    for _ in range(_MAX_SEGMENTS):
        segment = stepper.advance()
        left = (duration - segment.start) - segment.start_remainder
        last = segment.duration >= left
        span = left if last else segment.duration
        pieces += _pieces(p, segment, span)
        if last or len(pieces) >= _PIECES_AT_ONCE:
            for derivative in _derivatives(pieces):
                total = derivative @ total
            pieces = []
        state = _state_within(segment, span) if last else segment.final
        if last:
            return Flow(state, velocity(p, state, separation=separation), total)
    raise ComputationError(
        f"the motion over {duration:.6g} s needs more than {_MAX_SEGMENTS} steps",
        "use a less stiff contact",
    )


def velocity(p: Parameters, state: State, *, separation: bool) -> FloatArray:
    """Time derivative (ẋ, ẍ, ẏ, ÿ) of a state."""
    ax, ay = accelerations(p, state, mode_of(p, state, separation=separation))
    return np.array([state[1], ax, state[3], ay])


def _state_within(segment: Segment, span: float) -> State:
    evaluate = state_function(len(segment.x) - 1)
    x, vx, y, vy = evaluate(segment.x, segment.y, span / segment.duration)
    return (x, vx / segment.duration, y, vy / segment.duration)


def _pieces(p: Parameters, segment: Segment, span: float) -> list[_Piece]:
    # A deviation oscillates at the system's frequency however slow the motion is: over pieces of
    # less than a radian its series converges.
    c = constants(p, segment.mode)
    end = span / segment.duration
    farthest = float(np.abs(segment.y) @ end ** np.arange(float(len(segment.y))))
    ends = np.linspace(0.0, end, max(math.ceil(_fastest(c, farthest) * span), 1) + 1).tolist()
    return [
        _Piece(c, restricted(segment.y, left, right), (right - left) * segment.duration)
        for left, right in pairwise(ends)
    ]


def _fastest(c: Constants, y: float) -> float:
    # A bound of the frequencies and decay rates of deviations up to this |y|, 1/s.
    push = 3.0 * abs(c.cubic) * y * y
    horizontal = abs(c.xx) + abs(c.xy) + abs(c.friction) * push
    vertical = abs(c.yx) + abs(c.yy) + push
    return math.sqrt(max(horizontal, vertical)) + max(abs(c.xvx), abs(c.yvy))


def _derivatives(pieces: Sequence[_Piece]) -> FloatArray:
    # Of all pieces at once, shape (pieces, 4, 4): four deviations, a column each, in
    # θ = (time since the start of the piece)/duration.
    count = len(pieces)
    y = np.zeros((count, _DEGREE + 1))
    for row, piece in zip(y, pieces, strict=True):
        known = piece.y[: _DEGREE + 1]
        row[: len(known)] = known
    square = np.zeros_like(y)
    for n in range(_DEGREE + 1):
        square[:, n:] += y[:, n, None] * y[:, : _DEGREE + 1 - n]
    duration = np.array([piece.duration for piece in pieces])[:, None, None]
    stiffness = duration**2 * np.array([[[p.c.xx, p.c.xy], [p.c.yx, p.c.yy]] for p in pieces])
    damping = duration * np.array([[[p.c.xvx], [p.c.yvy]] for p in pieces])
    push = 3.0 * duration**2 * np.array([[[p.c.cubic * p.c.friction], [p.c.cubic]] for p in pieces])
    z = np.zeros((count, _DEGREE + 1, 2, _SIZE))
    z[:, 0, 0, 0] = z[:, 0, 1, 2] = 1.0
    z[:, 1, 0, 1] = z[:, 1, 1, 3] = duration[:, 0, 0]
    for n in range(_DEGREE - 1):
        force = stiffness @ z[:, n] - push * (square[:, None, n::-1] @ z[:, : n + 1, 1])
        z[:, n + 2] = (force / (n + 1) + damping * z[:, n + 1]) / (n + 2)
    place = z.sum(axis=1)
    speed = np.einsum("n,pnij->pij", np.arange(_DEGREE + 1.0), z) / duration
    return np.stack([place[:, 0], speed[:, 0], place[:, 1], speed[:, 1]], axis=1)

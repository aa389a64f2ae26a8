"""Deviations from a motion: its derivatives by numbers that its start and parameters depend on.

With the symbols of `series`, and ′ for the change of a coefficient with such a number, a deviation
δz = (δx, δy) obeys the variational equations

    δz̈ = a δx + (b − 3 d y²) δy + C δż + a′ x + b′ y + C′ ż − d′ y³ − (0, (F/m)′)

It oscillates at the system's frequencies however slow the motion is: over a segment of the motion
it takes pieces of its own, on each of which motion and deviation are expanded anew.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate, repeat
from operator import mul
from typing import Final, NamedTuple

from fivtui.model.errors import ComputationError
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.parameters import Parameters
from fivtui.model.slider_belt import LEAST, State, accelerations

from .segment import Segment
from .series import (
    Coefficients,
    Constants,
    coefficient_function,
    constants,
    right_hand_side,
    state_function,
)
from .stepper import overflow_error

ORDER: Final = 20
# The last terms of a piece over the greatest of its first ones, and how many these are.
_NEGLIGIBLE: Final = 2.0**-54
_FIRST_TERMS: Final = 9
_NOTHING: Final = (0.0,) * (ORDER + 2)
_SHORTENED: Final = 0.8
_MOST_SHORTENINGS: Final = 64


class Seed(NamedTuple):
    """How the start (x, ẋ, y, ẏ), and parameters by name, change with a number."""

    start: State
    parameters: Mapping[str, float] = {}


class FieldChange(NamedTuple):
    """Derivatives of the factors of x, y, ẋ, ẏ and y³ in ẍ and ÿ, and of F/m, by a number."""

    xx: float
    xy: float
    yx: float
    yy: float
    xvx: float
    yvy: float
    xyyy: float
    yyyy: float
    load: float


class _Piece(NamedTuple):
    # The motion over a piece, in time since its start: coefficients of x, y, y² and y³.
    x: tuple[float, ...]
    y: tuple[float, ...]
    square: Sequence[float]
    cube: Sequence[float]


Series = tuple[list[float], list[float]]


def change_of(p: Parameters, mode: Mode, by: Mapping[str, float]) -> FieldChange:
    """How the equations of motion change with parameters that change as `by` says."""
    c = constants(p, mode)
    relative = by.get("m", 0.0) / p.m
    dh = 0.5 * by.get("k3", 0.0)
    touching = float(mode is Mode.CONTACT)
    k2, dk2 = touching * p.k2, touching * by.get("k2", 0.0)
    k_nl, dk_nl = touching * p.k_nl, touching * by.get("k_nl", 0.0)
    dmu = by.get("mu", 0.0)
    return FieldChange(
        -(by.get("k1", 0.0) + dh) / p.m - c.xx * relative,
        (dh - dmu * k2 - p.mu * dk2) / p.m - c.xy * relative,
        dh / p.m - c.yx * relative,
        -(dh + dk2) / p.m - c.yy * relative,
        -by.get("c1", 0.0) / p.m - c.xvx * relative,
        -by.get("c2", 0.0) / p.m - c.yvy * relative,
        -(dmu * k_nl + p.mu * dk_nl) / p.m + p.mu * c.cubic * relative,
        -dk_nl / p.m + c.cubic * relative,
        by.get("F", 0.0) / p.m - c.load * relative,
    )


def past_switch(
    deviation: State, jump: Sequence[float], gradient: Sequence[float], change: float, rate: float
) -> State:
    """A deviation behind a switch where a guard g(state, parameters) vanishes.

    A deviation δ moves the switch by −(∇g·δ + g′)/(∇g·f⁻), hence

        δ⁺ = δ + (f⁺ − f⁻) (∇g·δ + g′)/(∇g·f⁻),

    the saltation matrix I + (f⁺ − f⁻) ∇gᵀ/(∇g·f⁻) with its part by parameters.

    Parameters
    ----------
    deviation : State
        δ.
    jump, gradient : sequence of four floats
        f⁺ − f⁻, by which the rate of change of the state jumps, and ∇g.
    change, rate : float
        g′, how the guard changes with the number itself, and ∇g·f⁻. Where the rate of change does
        not jump, the matrix is the identity, also where the guard is touched only.
    """
    if not any(jump):
        return deviation
    moved = (math.fsum(map(mul, gradient, deviation)) + change) / rate
    x, vx, y, vy = (value + leap * moved for value, leap in zip(deviation, jump, strict=True))
    return (x, vx, y, vy)


def unbounded_error(t: float) -> ComputationError:
    """The error for deviations that overflow or change too fast at a time, s."""
    return ComputationError(
        f"deviations from the motion cannot be followed beyond t = {t:.6g} s",
        "end before that time, or use a less stiff contact",
    )


class Deviations:
    """Deviations from one motion, carried along its segments.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    seeds : sequence of Seed
        What to derive by.
    """

    def __init__(self, p: Parameters, seeds: Sequence[Seed]) -> None:
        self._p = p
        self._constants = {mode: constants(p, mode) for mode in ALWAYS_SLIDING}
        self._changes = {
            mode: [change_of(p, mode, seed.parameters) for seed in seeds] for mode in ALWAYS_SLIDING
        }
        # Where y³ plays no part it may overflow.
        self._cubic = {
            mode: any(one.yyyy or one.xyyy for one in self._changes[mode])
            or self._constants[mode].cubic > 0.0
            for mode in ALWAYS_SLIDING
        }
        self.now: list[State] = [seed.start for seed in seeds]

    def advance(
        self, segment: Segment, end: float = 1.0, places: Sequence[float] = ()
    ) -> list[list[State]]:
        """Carry the deviations over the next segment of the motion.

        Parameters
        ----------
        segment : Segment
            It begins where the last one ended.
        end : float
            θ at which to stop.
        places : sequence of float
            Values of θ from 0 to `end`.

        Returns
        -------
        list of list of State
            The deviations of (x, ẋ, y, ẏ) at each of the places.

        Raises
        ------
        ComputationError
            If motion or deviations cannot be followed on.
        """
        mode, span = segment.mode, end * segment.duration
        moments = [place * segment.duration for place in places]
        found: list[list[State]] = [[] for _ in places]
        waiting = sorted(range(len(moments)), key=moments.__getitem__, reverse=True)
        done = 0.0
        while done < span:
            motion, series = self._series(mode, segment, done)
            left = span - done
            length = _length(series, left)
            if length == 0.0:
                t = segment.start + done
                size = sum(n * abs(one) for z in motion for n, one in enumerate(z, 1))
                raise (
                    unbounded_error(t)
                    if math.isfinite(size)
                    else overflow_error(t, segment.state(t), self._p)
                )
            while waiting and (length == left or moments[waiting[-1]] <= done + length):
                place = waiting.pop()
                found[place] = [_at(one, moments[place] - done) for one in series]
            self.now = [_at(one, length) for one in series]
            done = span if length == left else done + length
        if segment.switches and end == 1.0:
            self._switch(segment)
        return found

    def _series(
        self, mode: Mode, segment: Segment, since: float
    ) -> tuple[Coefficients, list[Series]]:
        """The motion, and each deviation from it, expanded at a time since the segment's start."""
        piece = self._expanded(mode, segment, since)
        return (piece.x, piece.y), [
            _deviation(self._constants[mode], change, start, piece)
            for change, start in zip(self._changes[mode], self.now, strict=True)
        ]

    def _expanded(self, mode: Mode, segment: Segment, since: float) -> _Piece:
        duration = segment.duration
        evaluate = state_function(len(segment.x) - 1)
        x, vx, y, vy = evaluate(segment.x, segment.y, since / duration)
        expand = coefficient_function(right_hand_side(self._p, mode), ORDER)
        xs, ys = expand(x, vx / duration, y, vy / duration, *self._constants[mode])
        if not self._cubic[mode]:
            return _Piece(xs, ys, _NOTHING, _NOTHING)
        square = product_of(ys, ys)
        return _Piece(xs, ys, square, product_of(ys, square))

    def _switch(self, segment: Segment) -> None:
        """Carry the deviations over the switch at the end of a segment."""
        # The guard is y, in which no parameter is.
        other = Mode.SEPARATED if segment.mode is Mode.CONTACT else Mode.CONTACT
        before = accelerations(self._p, segment.final, segment.mode)
        after = accelerations(self._p, segment.final, other)
        jump = (0.0, after[0] - before[0], 0.0, after[1] - before[1])
        rate = segment.final[3]
        self.now = [past_switch(one, jump, (0.0, 0.0, 1.0, 0.0), 0.0, rate) for one in self.now]


def product_of(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """Coefficients of a product of two series, as many as these have."""
    return [sum(map(mul, a[: n + 1], b[n::-1])) for n in range(len(a))]


def _deviation(c: Constants, change: FieldChange, start: State, motion: _Piece) -> Series:
    # Its Taylor coefficients.
    x, y = [start[0], start[1]], [start[2], start[3]]
    push_x, push_y = 3.0 * c.friction * c.cubic, 3.0 * c.cubic
    for n in range(ORDER):
        product = sum(map(mul, motion.square[n::-1], y))
        vx, vy = (n + 1) * motion.x[n + 1], (n + 1) * motion.y[n + 1]
        given_x = change.xx * motion.x[n] + change.xy * motion.y[n] + change.xvx * vx
        given_y = change.yx * motion.x[n] + change.yy * motion.y[n] + change.yvy * vy
        given_x += change.xyyy * motion.cube[n]
        given_y += change.yyyy * motion.cube[n] - (change.load if n == 0 else 0.0)
        share = 1.0 / ((n + 1) * (n + 2))
        force_x = c.xx * x[n] + c.xy * y[n] + c.xvx * (n + 1) * x[n + 1] - push_x * product
        force_y = c.yx * x[n] + c.yy * y[n] + c.yvy * (n + 1) * y[n + 1] - push_y * product
        x.append((force_x + given_x) * share)
        y.append((force_y + given_y) * share)
    return x, y


def _length(series: Sequence[Series], left: float) -> float:
    # Of the next piece: all that is left, or one of equal parts of it; zero where the deviations
    # are out of the range of numbers or take too many pieces.
    if not all(math.isfinite(x[-1] + y[-1]) for x, y in series):
        return 0.0
    sizes = [list(map(max, map(abs, x), map(abs, y))) for x, y in series]
    length = left
    for _ in range(_MOST_SHORTENINGS):
        if all(_is_short(size, length) for size in sizes):
            return left / math.ceil(left / length)
        length *= _SHORTENED
    return 0.0


def _is_short(size: Sequence[float], length: float) -> bool:
    powers = accumulate(repeat(length, ORDER + 1), mul, initial=1.0)
    terms = list(map(mul, size, powers))
    scale = max(terms[:_FIRST_TERMS])
    # What is next to nothing may lose digits.
    return bool(scale <= LEAST or max(terms[-2:]) <= scale * _NEGLIGIBLE)


def _at(series: Series, t: float) -> State:
    # Next to nothing is nothing.
    x, vx, y, vy = state_function(ORDER + 1)(series[0], series[1], t)
    return (_settled(x), _settled(vx), _settled(y), _settled(vy))


def _settled(value: float) -> float:
    return value if abs(value) > LEAST else 0.0

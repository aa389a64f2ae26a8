"""The motion at given times, as a function of time, and between two states.

θ is the time since the start of a segment relative to its duration.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fivtui.model import (
    COLUMNS,
    CONSTANT,
    IN_CONTACT,
    Column,
    InputError,
    Mode,
    Parameters,
    Rates,
    State,
    System,
    accelerations,
    parameters_after,
    spring_force,
)
from fivtui.results import Result, Table, Tabular, equal_values
from fivtui.taylor import Segment

__all__ = ["COLUMNS", "Column", "DenseSolution", "Trajectory"]

FloatArray = NDArray[np.float64]
# Parameters of the contact spring; like other stiffnesses they are held between rows of a table.
CONTACT_SPRING: Final = frozenset({"k2", "k_nl"})
_IS_IN_CONTACT: NDArray[np.bool_] = np.array([mode in IN_CONTACT for mode in Mode])


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectory(Result, Tabular):
    """The motion at n times, in SI units.

    Attributes
    ----------
    t, x, vx, y, vy, P : ndarray, shape (n,)
        Time, displacements, velocities and contact force.
    mode : ndarray of int8, shape (n,)
        See `Mode`.
    """

    t: FloatArray
    x: FloatArray
    vx: FloatArray
    y: FloatArray
    vy: FloatArray
    P: FloatArray
    mode: NDArray[np.int8]

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """One trajectory from consecutive parts, at least one."""
        arrays: dict[str, NDArray[Any]] = {
            column.name: np.concatenate([getattr(part, column.name) for part in parts])
            for column in COLUMNS
        }
        return cls(**arrays)

    def _summary(self) -> list[tuple[str, str]]:
        rows = [("samples", f"{self.t.size}")]
        if self.t.size == 0:
            return rows
        for column in COLUMNS:
            if column.name != "mode":
                values = getattr(self, column.name)
                text = f"{values.min():.6g} to {values.max():.6g} {column.unit}"
                rows.append((column.name, text))
        separated_count = np.count_nonzero(~is_in_contact(self.mode))
        return [*rows, ("off the belt", f"{separated_count} samples")]

    def _table(self) -> Table:
        return {column: getattr(self, column.name) for column in COLUMNS}


class DenseSolution:
    """The motion as a function of time: the polynomials of all segments.

    Parameters
    ----------
    system : System
        The system, for the contact force.
    segments : sequence of Segment
        Consecutive segments, at least one.
    """

    def __init__(self, system: System, segments: Sequence[Segment]) -> None:
        # Polynomials of lower degree are padded with zeros.
        size = max(len(segment.x) for segment in segments)
        x, y = np.zeros((2, size, len(segments)))
        for column, segment in enumerate(segments):
            x[: len(segment.x), column] = segment.x
            y[: len(segment.y), column] = segment.y
        rows = [
            (segment.start, segment.start_remainder, segment.duration, segment.end, segment.mode)
            for segment in segments
        ]
        self._store(system, np.array(rows, dtype=float), x, y)

    @classmethod
    def from_arrays(cls, system: System, rows: FloatArray, x: FloatArray, y: FloatArray) -> Self:
        """Construct the solution from arrays of n segments.

        `rows`, shape (n, 5), has for each segment its start, the rounding remainder of the start
        (exact less rounded), duration and end, s, and mode. `x` and `y`, shape (degree + 1, n),
        have coefficients of powers of θ, m.
        """
        solution = cls.__new__(cls)
        solution._store(system, rows, x, y)
        return solution

    def _store(self, system: System, rows: FloatArray, x: FloatArray, y: FloatArray) -> None:
        self._system, self._x, self._y = system, x, y
        self._start, self._remainder, self._duration, end, mode = rows.T
        self._mode = mode.astype(np.int8)
        self.t_start, self.t_end = float(self._start[0]), float(end[-1])

    def __eq__(self, value: object) -> bool:
        if not isinstance(value, DenseSolution):
            return NotImplemented
        return equal_values(vars(self), vars(value))

    def __hash__(self) -> int:
        return hash((self._system, self.t_start, self.t_end))

    def __repr__(self) -> str:
        span = f"{self.t_start:g} to {self.t_end:g} s"
        return f"<{type(self).__name__}, {span}, {self._start.size} segments>"

    def __call__(self, times: ArrayLike) -> Trajectory:
        """The motion at times in s, shape (n,); `InputError` if one lies outside."""
        t = np.atleast_1d(np.asarray(times, dtype=float))
        if t.size and not (t.min() >= self.t_start and t.max() <= self.t_end):
            raise InputError(f"times: must be from {self.t_start:g} to {self.t_end:g} s")
        index = np.maximum(np.searchsorted(self._start, t, side="right") - 1, 0)
        duration = self._duration[index]
        theta = ((t - self._start[index]) - self._remainder[index]) / duration
        x, vx = _horner(self._x[:, index], theta)
        y, vy = _horner(self._y[:, index], theta)
        states = x, vx / duration, y, vy / duration
        return build_trajectory(self._system, t, states, self._mode[index])


def is_in_contact(mode: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Whether the slider touches the belt, for an array of modes."""
    flags: NDArray[np.bool_] = _IS_IN_CONTACT[mode]
    return flags


def build_trajectory(
    system: System,
    t: FloatArray,
    states: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    mode: NDArray[np.int8],
    buffer: FloatArray | None = None,
) -> Trajectory:
    """The trajectory of states (x, ẋ, y, ẏ); the contact force is written to `buffer`, if any."""
    x, vx, y, vy = states
    force = np.empty_like(y) if buffer is None else buffer
    springs = {}
    for name in CONTACT_SPRING & {*system.over_time}:
        table = system.over_time[name]
        index = np.searchsorted(table.times, t, side="right") - 1
        springs[name] = np.array(table.values)[np.maximum(index, 0)]
    p = system.parameters.replaced(**springs) if springs else system.parameters
    force[:] = spring_force(p, y)
    force[~is_in_contact(mode)] = 0.0
    return Trajectory(t, x, vx, y, vy, force, mode)


def _horner(coefficients: FloatArray, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Values and derivatives by θ of polynomials, one per column, by Horner's scheme.
    value, slope = coefficients[-1], np.zeros_like(theta)
    for coefficient in coefficients[-2::-1]:
        slope = slope * theta + value
        value = value * theta + coefficient
    return value, slope


def segment_between(
    p: Parameters,
    mode: Mode,
    times: tuple[float, float],
    states: tuple[State, State],
    *,
    next_mode: Mode,
    rates: Rates = CONSTANT,
) -> Segment:
    """The motion between two states in one mode: quintic Hermite interpolation.

    `rates` are the derivatives by time of parameters that change; `p` has their values at the
    start.
    """
    start, end = times
    duration = end - start
    first, final = states
    x0, vx0, y0, vy0 = first
    x1, vx1, y1, vy1 = final
    ax0, ay0 = accelerations(p, first, mode, rates)
    ax1, ay1 = accelerations(parameters_after(p, rates, duration), final, mode, rates)
    return Segment(
        mode=mode,
        start=start,
        start_remainder=0.0,
        duration=duration,
        end=end,
        x=_quintic(duration, (x0, vx0, ax0), (x1, vx1, ax1)),
        y=_quintic(duration, (y0, vy0, ay0), (y1, vy1, ay1)),
        final=final,
        next_mode=next_mode,
    )


def _quintic(
    duration: float, start: tuple[float, float, float], end: tuple[float, float, float]
) -> tuple[float, ...]:
    # Coefficients of a polynomial of θ from position, velocity and acceleration at both ends. The
    # start gives the quadratic part; the remainders are what it lacks at the end.
    (x0, v0, a0), (x1, v1, a1) = start, end
    c0, c1, c2 = x0, v0 * duration, 0.5 * a0 * duration * duration
    x_remainder = x1 - (c0 + c1 + c2)
    v_remainder = v1 * duration - (c1 + 2.0 * c2)
    a_remainder = a1 * duration * duration - 2.0 * c2
    return (
        c0,
        c1,
        c2,
        10.0 * x_remainder - 4.0 * v_remainder + 0.5 * a_remainder,
        -15.0 * x_remainder + 7.0 * v_remainder - a_remainder,
        6.0 * x_remainder - 3.0 * v_remainder + 0.5 * a_remainder,
    )

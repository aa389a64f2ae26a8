"""The motion at given times, and the motion as a function of time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .columns import COLUMNS, Column
from .errors import InputError
from .model import Mode
from .parameters import Parameters
from .segment import Segment

__all__ = ["COLUMNS", "Column", "DenseSolution", "Trajectory"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Trajectory:
    """The motion at n times, in SI units.

    Attributes
    ----------
    t, x, vx, y, vy, P : ndarray, shape (n,)
        Time, displacements, velocities and contact force.
    mode : ndarray of int8, shape (n,)
        1 in contact, 0 separated (`Mode`).
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
        """One trajectory from consecutive parts.

        Parameters
        ----------
        parts : sequence of Trajectory
            At least one.

        Returns
        -------
        Trajectory
            All their times in order.
        """
        columns = (c.name for c in COLUMNS)
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in columns))


class DenseSolution:
    """The motion as a function of time: the polynomials of all segments.

    Parameters
    ----------
    p : Parameters
        The parameter set, for the contact force.
    segments : sequence of Segment
        Consecutive segments, at least one.
    """

    def __init__(self, p: Parameters, segments: Sequence[Segment]) -> None:
        self._p = p
        size = max(len(s.x) for s in segments)
        self._start = np.array([s.start for s in segments])
        self._remainder = np.array([s.start_remainder for s in segments])
        self._duration = np.array([s.duration for s in segments])
        self._mode = np.array([s.mode for s in segments], dtype=np.int8)
        self._x = np.zeros((size, len(segments)))
        self._y = np.zeros((size, len(segments)))
        for column, segment in enumerate(segments):
            self._x[: len(segment.x), column] = segment.x
            self._y[: len(segment.y), column] = segment.y
        self.t_start = segments[0].start
        self.t_end = segments[-1].end

    def __call__(self, times: ArrayLike) -> Trajectory:
        """Evaluate the motion.

        Parameters
        ----------
        times : array_like, shape (n,)
            Times in [t_start, t_end], s.

        Returns
        -------
        Trajectory
            The motion at those times.

        Raises
        ------
        InputError
            If a time lies outside.
        """
        t = np.atleast_1d(np.asarray(times, dtype=float))
        if t.size and not (t.min() >= self.t_start and t.max() <= self.t_end):
            raise InputError(f"times: allowed is {self.t_start:g} to {self.t_end:g} s")
        index = np.maximum(np.searchsorted(self._start, t, side="right") - 1, 0)
        duration = self._duration[index]
        theta = ((t - self._start[index]) - self._remainder[index]) / duration
        x, vx = _horner(self._x[:, index], theta)
        y, vy = _horner(self._y[:, index], theta)
        mode = self._mode[index]
        force = (-self._p.k2 - self._p.k_nl * y * y) * y
        force = np.where(mode == Mode.CONTACT, force, 0.0)
        return Trajectory(t, x, vx / duration, y, vy / duration, force, mode)


def _horner(c: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Value and derivative of one polynomial per column.
    value, slope = c[-1], np.zeros_like(t)
    for row in c[-2::-1]:
        slope = slope * t + value
        value = value * t + row
    return value, slope

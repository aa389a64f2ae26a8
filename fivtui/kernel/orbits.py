"""Periodic orbits by the compiled kernel: Newton's method on shooting, without leaving it."""

import ctypes
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS

Floats = NDArray[np.float64]

_STATE: Final = 4
_MOST_VARIED: Final = 2
_UNKNOWNS: Final = _STATE + 1 + _MOST_VARIED
_EXTREMES: Final = 7
_double, _int = ctypes.c_double, ctypes.c_int64


class _Asked(ctypes.Structure):
    # Layout of the struct `Asked` in orbit.c.
    _fields_ = (
        ("parameters", _double * len(PARAMETERS)),
        ("scales", _double * _UNKNOWNS),
        ("low", _double * _MOST_VARIED),
        ("high", _double * _MOST_VARIED),
        ("tol", _double),
        ("longest", _double),
        ("places", _int * _MOST_VARIED),
        ("varied", _int),
        ("separation", _int),
        ("order", _int),
        ("budget", _int),
    )


# Ends of the parts of the struct `Orbit` in orbit.c.
_PARTS: Final = np.cumsum([_UNKNOWNS, _UNKNOWNS, _STATE, 9, _EXTREMES]).tolist()
_FOUND: Final = _PARTS[-1] + 2


class FoundOrbit(NamedTuple):
    """A periodic orbit: scaled unknowns and derived quantities for `fivtui.orbits`."""

    unknowns: Floats
    tangent: Floats
    flow_direction: Floats
    monodromy: Floats
    extremes: Floats
    determinant: float
    iterations: int


class Varied(NamedTuple):
    """A parameter that varies: its column among all parameters, and its bounds."""

    column: int
    low: float
    high: float


class OrbitSearch:
    """A search of periodic orbits of a parameter set of which one or two parameters vary.

    `scales` are the units of state, period and varied parameters, `longest` is the greatest period,
    s, and `budget` limits the steps of a motion.
    """

    def __init__(
        self,
        function: Any,
        size: int,
        *,
        parameters: Sequence[float],
        varied: Sequence[Varied],
        scales: Floats,
        separation: bool,
        tol: float,
        order: int,
        longest: float,
        budget: int,
    ) -> None:
        self._function, self._memory = function, np.empty(size)
        count = len(varied)
        self._request = _Asked(
            tuple(parameters),
            tuple(scales),
            tuple(parameter.low for parameter in varied),
            tuple(parameter.high for parameter in varied),
            tol,
            longest,
            tuple(parameter.column for parameter in varied),
            count,
            separation,
            order,
            budget,
        )
        self._count = _STATE + 1 + count

    def solve(
        self, guess: Floats, planes: Floats, along: Floats, *, turning: bool
    ) -> FoundOrbit | None:
        """The orbit near a guess of the n scaled unknowns; None if Newton's method finds none.

        The search runs in the planes through the guess with the normals `planes`, shape (n − 4, n).
        The new tangent has the direction of `along` on the curve of orbits; it is in the plane
        across the orbit if `turning`, else in the first.
        """
        orbit = np.empty(_FOUND)
        arguments = np.concatenate([guess, along, planes.ravel()])
        start, item = arguments.ctypes.data, arguments.itemsize
        if not self._function(
            self._memory.ctypes.data,
            ctypes.addressof(self._request),
            start,
            start + 2 * item * self._count,
            start + item * self._count,
            turning,
            orbit.ctypes.data,
        ):
            return None
        determinant, iterations = orbit[_PARTS[-1] :].tolist()
        unknowns, tangent, flow_direction, monodromy, extremes = (
            orbit[begin:end] for begin, end in zip([0, *_PARTS], _PARTS, strict=False)
        )
        count = self._count
        return FoundOrbit(
            unknowns[:count],
            tangent[:count],
            flow_direction,
            monodromy.reshape(3, 3),
            extremes,
            determinant,
            int(iterations),
        )

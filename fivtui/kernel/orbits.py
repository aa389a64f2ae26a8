"""Periodic orbits by shooting and Newton's method, all in the compiled kernel."""

import ctypes
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS

Floats = NDArray[np.float64]

_STATE_SIZE: Final = 4
_MAX_VARIED: Final = 2
_MAX_UNKNOWNS: Final = _STATE_SIZE + 1 + _MAX_VARIED
_EXTREMES: Final = 7
_double, _int = ctypes.c_double, ctypes.c_int64


class _Request(ctypes.Structure):
    # Layout of the struct `OrbitRequest` in orbit.c.
    _fields_ = (
        ("parameters", _double * len(PARAMETERS)),
        ("scales", _double * _MAX_UNKNOWNS),
        ("low", _double * _MAX_VARIED),
        ("high", _double * _MAX_VARIED),
        ("tol", _double),
        ("max_period", _double),
        ("columns", _int * _MAX_VARIED),
        ("varied", _int),
        ("separation", _int),
        ("order", _int),
        ("budget", _int),
    )


# End offsets of the arrays in the struct `Orbit` in orbit.c.
_PART_ENDS: Final = np.cumsum([_MAX_UNKNOWNS, _MAX_UNKNOWNS, _STATE_SIZE, 9, _EXTREMES]).tolist()
_RESULT_SIZE: Final = _PART_ENDS[-1] + 2


class FoundOrbit(NamedTuple):
    """A periodic orbit in scaled units, with the tangent of the curve of orbits and its flow."""

    unknowns: Floats
    tangent: Floats
    flow_direction: Floats
    monodromy: Floats
    extremes: Floats
    determinant: float
    iterations: int


class VariedParameter(NamedTuple):
    """A parameter that varies along the curve of orbits: its column and its bounds."""

    column: int
    low: float
    high: float


class OrbitSearch:
    """A search for periodic orbits of a parameter set of which one or two parameters vary.

    `scales` are the units of state, period and varied parameters, `max_period` is in s, and
    `budget` limits the steps of a period.
    """

    def __init__(
        self,
        function: Any,
        size: int,
        *,
        parameters: Sequence[float],
        varied: Sequence[VariedParameter],
        scales: Floats,
        separation: bool,
        tol: float,
        order: int,
        max_period: float,
        budget: int,
    ) -> None:
        self._function, self._memory = function, np.empty(size)
        count = len(varied)
        self._request = _Request(
            tuple(parameters),
            tuple(scales),
            tuple(parameter.low for parameter in varied),
            tuple(parameter.high for parameter in varied),
            tol,
            max_period,
            tuple(parameter.column for parameter in varied),
            count,
            separation,
            order,
            budget,
        )
        self._count = _STATE_SIZE + 1 + count

    def solve(
        self, guess: Floats, planes: Floats, direction: Floats, *, tangent_across: bool
    ) -> FoundOrbit | None:
        """The orbit near a guess of the n scaled unknowns; None if Newton's method finds none.

        The search runs in the planes through the guess with the normals `planes`, shape (n − 4, n).
        The new tangent has a positive component along `direction`. It is normal to the orbit if
        `tangent_across`, else to the first of `planes`.
        """
        orbit = np.empty(_RESULT_SIZE)
        arguments = np.concatenate([guess, direction, planes.ravel()])
        address, item_size = arguments.ctypes.data, arguments.itemsize
        if not self._function(
            self._memory.ctypes.data,
            ctypes.addressof(self._request),
            address,
            address + 2 * item_size * self._count,
            address + item_size * self._count,
            tangent_across,
            orbit.ctypes.data,
        ):
            return None
        determinant, iterations = orbit[_PART_ENDS[-1] :].tolist()
        unknowns, tangent, flow_direction, monodromy, extremes = (
            orbit[begin:end] for begin, end in zip([0, *_PART_ENDS], _PART_ENDS, strict=False)
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

"""Periodic orbits by shooting and Newton's method, all in the compiled kernel.

The unknowns of a search are the state (x, ẋ, y, ẏ) at the start, the period, and one or two varied
parameters, each in its own unit. Orbits form a curve as parameters vary.
"""

import ctypes
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS

from .runs import EXTREMES

Floats = NDArray[np.float64]

_STATE_SIZE: Final = 4
_MAX_VARIED: Final = 2
_MAX_UNKNOWNS: Final = _STATE_SIZE + 1 + _MAX_VARIED
# Rows and columns of the monodromy matrix: it acts on the hyperplane normal to the flow, which has
# one dimension less than the state.
_HYPERPLANE_SIZE: Final = _STATE_SIZE - 1
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
        ("varied_count", _int),
        ("separation", _int),
        ("order", _int),
        ("budget", _int),
    )


# The struct `Orbit` in orbit.c: sizes of its arrays, in the order of the fields of `FoundOrbit`.
_ARRAY_SIZES: Final = (_MAX_UNKNOWNS, _MAX_UNKNOWNS, _STATE_SIZE, _HYPERPLANE_SIZE**2, EXTREMES)
# Index after the last number of each array.
_ARRAY_ENDS: Final = np.cumsum(_ARRAY_SIZES).tolist()
# Numbers in the struct: after the arrays, the determinant and the count of iterations.
_ORBIT_SIZE: Final = _ARRAY_ENDS[-1] + 2


class FoundOrbit(NamedTuple):
    """A periodic orbit in scaled units; only `extremes` are in SI units.

    `tangent` is that of the curve of orbits, `flow_direction` the unit vector of (ẋ, ẍ, ẏ, ÿ) at
    the start. `extremes` are least and greatest x, least and greatest y, greatest ẋ, and least and
    greatest y in the second half of the period.

    `determinant` is that of an n×n matrix for n unknowns. Its rows are the four linearised
    equations of a closed orbit, the normals of `OrbitSearch.solve` without the last one, and the
    tangent. If the tangent is normal to the flow, the flow replaces the first normal.
    """

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

    `function` is `orbit_solve` of orbit.c, which needs a work memory of `memory_size` floats.
    `scales` are the units of state, period and varied parameters, `max_period` is in s. Periods are
    computed in Taylor steps of an `order`, with the local tolerance `tol`, in at most `budget`
    steps. `separation` is whether the slider can leave the belt.
    """

    def __init__(
        self,
        function: Any,
        memory_size: int,
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
        self._function, self._memory = function, np.empty(memory_size)
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
        self, guess: Floats, normals: Floats, heading: Floats, *, is_normal_to_flow: bool
    ) -> FoundOrbit | None:
        """The orbit near a guess of the n scaled unknowns; None if Newton's method finds none.

        Four of n equations close the orbit. The others, n − 4, keep the solution in hyperplanes
        through the guess, whose normals are the rows of `normals`.

        The tangent of the curve of orbits has a positive component along `heading`. A shift of
        the start along the orbit is no new orbit, so the tangent must be normal to a vector that
        excludes it. This is the flow if `is_normal_to_flow`, else the first row of `normals`.
        """
        orbit = np.empty(_ORBIT_SIZE)
        # One array for the three inputs: it takes longer to read an address from `ctypes.data` than
        # to compute it by an addition.
        arguments = np.concatenate([guess, normals.ravel(), heading])
        guess_address = arguments.ctypes.data
        normals_address = guess_address + guess.nbytes
        heading_address = normals_address + normals.nbytes
        if not self._function(
            self._memory.ctypes.data,
            ctypes.addressof(self._request),
            guess_address,
            normals_address,
            heading_address,
            is_normal_to_flow,
            orbit.ctypes.data,
        ):
            return None
        determinant, iterations = orbit[_ARRAY_ENDS[-1] :].tolist()
        unknowns, tangent, flow_direction, monodromy, extremes = (
            orbit[begin:end] for begin, end in zip([0, *_ARRAY_ENDS], _ARRAY_ENDS, strict=False)
        )
        count = self._count
        return FoundOrbit(
            unknowns[:count],
            tangent[:count],
            flow_direction,
            monodromy.reshape(_HYPERPLANE_SIZE, _HYPERPLANE_SIZE),
            extremes,
            determinant,
            int(iterations),
        )

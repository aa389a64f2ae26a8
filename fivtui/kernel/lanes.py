"""A batch of runs that the kernel computes side by side.

A lane is one element of a SIMD vector: each lane computes one run, then the next one.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import PARAMETERS

from .runs import COLUMNS

Floats = NDArray[np.float64]

_K_NL_COLUMN: Final = list(PARAMETERS).index("k_nl")
# Bytes of a cache line of the processor.
_CACHE_LINE: Final = 64


class LaneBatch:
    """n runs of a batch, by Taylor series of an order.

    `parameters`, shape (n, 9), have a cubic contact stiffness k_nl > 0 in all rows or in none;
    `separation`, shape (n,), says for each run whether the slider may leave the belt. `tol` is the
    local tolerance: the error of a step relative to the scale of the motion. The flags `observed`
    select extremes of y, all extremes, and extremes of y in the second half. `belts`, shape (n, 3),
    has v_belt, μ_s and v_s; v_s is 0 in all rows (constant friction) or in none.
    """

    def __init__(
        self,
        functions: dict[str, Any],
        *,
        parameters: Floats,
        separation: NDArray[np.bool_],
        starts: Floats,
        t_end: float,
        tol: float,
        order: int,
        max_steps: int,
        observed: tuple[bool, bool, bool],
        belts: Floats | None = None,
    ) -> None:
        prefix = "batch" if belts is None else "belts"
        size, self._advance, self._ended = (
            functions[f"{prefix}_{name}"] for name in ("size", "advance", "ended")
        )
        columns = parameters if belts is None else np.hstack([parameters, belts])
        self._parameters = np.ascontiguousarray(columns)
        self._starts = np.ascontiguousarray(starts)
        self._separation = np.ascontiguousarray(separation, dtype=np.uint8)
        self._count = count = len(parameters)
        self.results = np.empty((count, COLUMNS))
        self._memory = np.zeros(size() + _CACHE_LINE, dtype=np.uint8)
        # The memory's address, rounded up to a cache line.
        end_address = self._memory.ctypes.data + _CACHE_LINE - 1
        self._aligned_address = end_address - end_address % _CACHE_LINE
        has_cubic_spring = bool(count) and bool(self._parameters[0, _K_NL_COLUMN] > 0.0)
        self._options = (t_end, tol, float(max_steps), order, has_cubic_spring, *observed)

    def advance(self, budget: int) -> float:
        """Continue until all runs have ended or `budget` steps of all lanes have been taken.

        Returns the number of ended runs plus the computed fractions of the others.
        """
        return float(
            self._advance(
                self._aligned_address,
                self._parameters.ctypes.data,
                self._separation.ctypes.data,
                self._starts.ctypes.data,
                self.results.ctypes.data,
                self._count,
                *self._options,
                budget,
            )
        )

    @property
    def done(self) -> bool:
        """Whether all runs have ended."""
        return bool(self._ended(self._aligned_address) == self._count)

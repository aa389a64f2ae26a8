"""Batches of the kernel, under way: runs side by side in lanes."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .runs import COLUMNS

Floats = NDArray[np.float64]

_K_NL: Final = 7
# Bytes of a line of the processor's cache.
_LINE: Final = 64


class Work:
    """A chunk of a batch under way.

    Parameters
    ----------
    functions
        From `Kernel.work`.
    parameters : ndarray, shape (n, 9)
        Parameter sets, all with k_nl > 0 or all with k_nl = 0.
    separation : ndarray of bool, shape (n,)
        Whether separation is considered.
    starts : ndarray, shape (n, 4)
        States (x, ẋ, y, ẏ), m and m/s.
    t_end : float
        Horizon, s.
    tol, order
        Local tolerance and order of expansion.
    max_steps : int
        Steps after which a run is given up.
    observed : tuple of bool
        Whether extremes of y, all extremes, and those of y after half the horizon are wanted.
    belts : ndarray, shape (n, 3), optional
        v_belt, μ_s and v_s of belts of finite speed; v_s is 0 in all, friction being constant, or
        in none.
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
        size, self._go_on, self._ended = (
            functions[f"{'batch' if belts is None else 'belts'}_{name}"]
            for name in ("size", "advance", "ended")
        )
        given = parameters if belts is None else np.hstack([parameters, belts])
        self._parameters = np.ascontiguousarray(given)
        self._starts = np.ascontiguousarray(starts)
        self._separation = np.ascontiguousarray(separation, dtype=np.uint8)
        self._count = count = len(parameters)
        self.results = np.empty((count, COLUMNS))
        self._memory = np.zeros((size() + _LINE) // 8)
        self._place = -(-self._memory.ctypes.data // _LINE) * _LINE
        cubic = bool(count) and bool(self._parameters[0, _K_NL] > 0.0)
        self._asked = (t_end, tol, float(max_steps), order, cubic, *observed)

    def advance(self, budget: int) -> float:
        """Go on until all are ended or the budget, steps of all lanes, is spent.

        Returns
        -------
        float
            Runs ended, those under way counted by the part of the horizon behind them.
        """
        return float(
            self._go_on(
                self._place,
                self._parameters.ctypes.data,
                self._separation.ctypes.data,
                self._starts.ctypes.data,
                self.results.ctypes.data,
                self._count,
                *self._asked,
                budget,
            )
        )

    @property
    def done(self) -> bool:
        """Whether all are ended."""
        return bool(self._ended(self._place) == self._count)

"""A batch of runs that the kernel computes one after the other."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .runs import COLUMNS, KernelRun, RunColumns, Status

Floats = NDArray[np.float64]

_STATUS_COLUMN: Final = RunColumns._fields.index("status")


class SequentialBatch:
    """Runs of a batch, bit for bit those of `LaneBatch`; all extremes are recorded.

    `begin` is `Kernel.begin_run`; the other arguments are as of `LaneBatch`.
    """

    def __init__(
        self,
        begin: Callable[..., KernelRun],
        *,
        parameters: Floats,
        separation: NDArray[np.bool_],
        starts: Floats,
        t_end: float,
        tol: float,
        order: int,
        max_steps: int,
        belts: Floats | None = None,
    ) -> None:
        def begin_member(member: int) -> KernelRun:
            return begin(
                parameters[member].tolist(),
                starts[member].tolist(),
                separation=bool(separation[member]),
                t_end=t_end,
                tol=tol,
                order=order,
                belt=None if belts is None else tuple(belts[member].tolist()),
            )

        self._begin_member, self._t_end, self._max_steps = begin_member, t_end, max_steps
        self._member = 0
        self._run: KernelRun | None = None
        self.results = np.empty((len(parameters), COLUMNS))

    def advance(self, budget: int) -> float:
        """Continue until all runs have ended or `budget` steps have been taken.

        Returns the number of ended runs plus the computed fraction of the current run.
        """
        while budget > 0 and not self.done:
            run = self._run or self._begin_member(self._member)
            steps_before = 0 if self._run is None else int(run.outcome.steps)
            status = run.advance(min(budget, self._max_steps - steps_before))
            steps = int(run.outcome.steps)
            budget -= max(steps - steps_before, 1)
            if status is Status.RUNNING and steps >= self._max_steps:
                status = Status.STEP_LIMIT
            self._run = run
            if status is not Status.RUNNING:
                self.results[self._member] = run.outcome
                self.results[self._member, _STATUS_COLUMN] = status
                self._member, self._run = self._member + 1, None
        fraction = 0.0 if self._run is None else min(self._run.outcome.t / self._t_end, 1.0)
        return self._member + fraction

    @property
    def done(self) -> bool:
        """Whether all runs have ended."""
        return self._member == len(self.results)

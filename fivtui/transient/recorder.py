"""What is kept of a run while it goes on: extremes, events, samples."""

import math
from collections.abc import Callable, Sequence
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError, Mode, State, mode_of, unknown_name
from fivtui.taylor import Segment

from .extremes import Extremes
from .methods import Problem
from .result import Kernel, Stats, Transient, assemble
from .trajectory import DenseSolution, Trajectory

Samples = Literal["none", "dense"] | int | Sequence[float] | NDArray[np.float64]
# Takes the parts of a trajectory, one after the other, while the run goes on.
OnSamples = Callable[[Trajectory], None]

_CHUNK: Final = 256
_MOST_SAMPLES: Final = 100_000_000


class Recorder:
    """Takes in the segments of a run and keeps what its result requires, nothing else.

    Parameters
    ----------
    problem : Problem
        What is being integrated.
    samples : "none", "dense" or sequence of float
        Times at which the trajectory is kept, ascending, s; or all polynomials; or nothing.
    on_samples : callable, optional
        Called with every part of the trajectory at sample times as soon as it is known; no part is
        empty.

    Raises
    ------
    InputError
        If the times are not ascending or lie outside [0, t_end].
    """

    def __init__(
        self, problem: Problem, samples: Samples = "none", on_samples: OnSamples | None = None
    ) -> None:
        self._problem = problem
        self._extremes = Extremes()
        self._second_half = Extremes()
        self._half = 0.5 * problem.t_end
        self._switches: list[float] = []
        self._separated = [0.0]
        self._final: State = problem.start
        self._steps = 0
        self._dense = isinstance(samples, str) and samples == "dense"
        self._times = sample_times(samples, problem.t_end)
        self._kept: list[Segment] = []
        self._parts: list[Trajectory] = []
        self._on_samples = on_samples
        self.t = 0.0
        self.first_mode = mode_of(problem.parameters, problem.start, separation=problem.separation)
        self._separations = 0

    @property
    def problem(self) -> Problem:
        """What is being integrated."""
        return self._problem

    @property
    def t_end(self) -> float:
        """The horizon, s."""
        return self._problem.t_end

    @property
    def complete(self) -> bool:
        """Whether the horizon is reached."""
        return self.t >= self._problem.t_end

    def include(self, segment: Segment) -> None:
        """Take in the next segment.

        Parameters
        ----------
        segment : Segment
            It may reach beyond the horizon; what lies there does not count.
        """
        t_end = self._problem.t_end
        self._steps += 1
        self.t = segment.end
        if segment.end <= t_end:
            self._extremes.include(segment)
            self._final = segment.final
            duration = segment.duration
            if segment.switches:
                self._switches.append(segment.end)
                self._separations += segment.mode is Mode.CONTACT
        else:
            self._extremes.include_part(segment, segment.start, t_end)
            self._final = segment.state(t_end)
            duration = (t_end - segment.start) - segment.start_remainder
        if segment.end > self._half:
            if segment.start >= self._half and segment.end <= t_end:
                self._second_half.include(segment)
            else:
                self._second_half.include_part(segment, self._half, t_end)
        if segment.mode is Mode.SEPARATED:
            self._separated.append(duration)
        if self._times is not None:
            self._kept.append(segment)
            if len(self._kept) >= _CHUNK:
                self._sample(self._times)
        elif self._dense:
            self._kept.append(segment)

    def _sample(self, times: NDArray[np.float64]) -> None:
        # Evaluates the waiting segments at their sample times and lets them go.
        solution = DenseSolution(self._problem.parameters, self._kept)
        count = int(np.searchsorted(times, solution.t_end, side="right"))
        self._parts.append(solution(times[:count]))
        self._times = times[count:]
        self._kept = []
        if self._on_samples is not None and count > 0:
            self._on_samples(self._parts[-1])

    def result(self, method: str, kernel: Kernel | None = None) -> Transient:
        """The result of the run.

        Parameters
        ----------
        method : str
            Name of the method that made the segments.
        kernel : str, optional
            See `Stats`.

        Returns
        -------
        Transient
            Without CPU time, which the caller measures.

        Raises
        ------
        ComputationError
            If the contact force is out of the range of numbers.
        """
        if self._times is not None and self._kept:
            self._sample(self._times)
        return assemble(
            self._problem,
            method,
            final=self._final,
            whole=self._extremes,
            second_half=self._second_half,
            switches=np.array(self._switches),
            separations=self._separations,
            separated_time=math.fsum(self._separated),
            stats=Stats(steps=self._steps, kernel=kernel),
            first_mode=self.first_mode,
            trajectory=Trajectory.joined(self._parts) if self._parts else None,
            solution=(DenseSolution(self._problem.parameters, self._kept) if self._dense else None),
        )


def sample_times(samples: Samples, t_end: float) -> NDArray[np.float64] | None:
    """Check a request for samples.

    Parameters
    ----------
    samples : "none", "dense", int or sequence of float
        What is kept of the trajectory; a number of times is spread evenly over the run.
    t_end : float
        Horizon, s.

    Returns
    -------
    ndarray or None
        The times, s, if times were given.

    Raises
    ------
    InputError
        If the times are not ascending or lie outside [0, t_end], or are too few or too many.
    """
    if isinstance(samples, int | np.integer) and not isinstance(samples, bool):
        if not 2 <= samples <= _MOST_SAMPLES:
            raise InputError(f"samples = {samples}: must be 2 to {_MOST_SAMPLES}")
        return np.linspace(0.0, t_end, int(samples))
    if isinstance(samples, str):
        if samples not in ("none", "dense"):
            raise unknown_name("samples", samples, ("none", "dense"))
        return None
    times = np.atleast_1d(np.asarray(samples, dtype=float))
    inside = times.size > 0 and times[0] >= 0.0 and times[-1] <= t_end
    if not inside or not np.all(np.diff(times) >= 0.0):
        raise InputError(f"samples: must be ascending times from 0 to {t_end:g} s")
    return times

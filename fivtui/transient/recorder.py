"""The event loop over any integrator, which records extremes, events and samples of a run.

An integrator returns the motion in segments: polynomials over one step in one mode.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import IN_CONTACT, Progress, State
from fivtui.taylor import Extremes, Segment, Stepper

from .request import Kernel, OnSamples, Request
from .result import NO_CHANGES, SpringRange, Stats, Transient, build_transient
from .stiffness import step_limit_error
from .trajectory import CONTACT_SPRING, DenseSolution, Trajectory

# Number of segments that are sampled together, and of steps between progress reports.
_SEGMENTS_PER_CHUNK: Final = 256
_STEPS_PER_REPORT: Final = 32


class Recorder:
    """Collects the result of a run from its segments; stores them for samples and dense output."""

    def __init__(self, request: Request, on_samples: OnSamples | None = None) -> None:
        self._request = request
        self._extremes = Extremes()
        # The ranges of y under earlier contact springs; `_extremes` has that under `_spring`.
        self._ranges: list[SpringRange] = []
        self._spring = request.parameters
        self._second_half = Extremes()
        self._half_time = 0.5 * request.t_end
        # Times of separations and reattachments, s.
        self._switches: list[float] = []
        # On a belt of finite speed all switches: time, s, mode before, mode after.
        self._mode_changes: list[tuple[float, float, float]] = []
        self._separated_durations = [0.0]
        self._separations = 0
        self._final: State = request.initial
        self._steps = 0
        self._first_mode = request.first_mode
        self._on_belt = request.parameters.v_belt is not None
        # Remaining sample times, segments that wait to be sampled, and finished samples.
        self._times = request.times
        self._segments: list[Segment] = []
        self._parts: list[Trajectory] = []
        self._on_samples = on_samples
        # Time reached, s.
        self.t = 0.0

    def follow(self, stepper: Stepper, work: Progress) -> None:
        """Include the segments of an integrator until the horizon is reached."""
        t_end, max_steps = self._request.t_end, self._request.max_steps
        for count in range(max_steps):
            if count % _STEPS_PER_REPORT == 0:
                work.report(min(self.t / t_end, 1.0))
            self.include(stepper.advance())
            if self.t >= t_end:
                work.advance(1.0)
                return
        raise step_limit_error(self._request, self.t)

    def include(self, segment: Segment) -> None:
        """Include the next segment up to the horizon."""
        t_end = self._request.t_end
        if self._steps == 0 and self._on_belt:
            # A method that ignores stick may begin in a different mode than requested.
            self._first_mode = segment.mode
        self._steps += 1
        self.t = segment.end
        self._change_spring(segment.start)
        # The last segment may extend beyond the horizon.
        if segment.end <= t_end:
            self._extremes.include(segment)
            self._final = segment.final
            duration = segment.duration
            if segment.next_mode is not segment.mode:
                self._record_switch(segment)
        else:
            self._extremes.include_part(segment, segment.start, t_end)
            self._final = segment.state(t_end)
            # The exact start is start + start_remainder, since `start` is rounded.
            duration = (t_end - segment.start) - segment.start_remainder
        if segment.end > self._half_time:
            if segment.start >= self._half_time and segment.end <= t_end:
                self._second_half.include(segment)
            else:
                self._second_half.include_part(segment, self._half_time, t_end)
        if segment.mode not in IN_CONTACT:
            self._separated_durations.append(duration)
        if self._times is not None:
            self._segments.append(segment)
            if len(self._segments) >= _SEGMENTS_PER_CHUNK:
                self._sample(self._times)
        elif self._request.dense:
            self._segments.append(segment)

    def _change_spring(self, t: float) -> None:
        # Begin another range of y if the contact spring changes at a time, s.
        course = self._request.course
        if course is None or CONTACT_SPRING.isdisjoint(course.tables):
            return
        p, _ = course.after(t)
        if (p.k2, p.k_nl) != (self._spring.k2, self._spring.k_nl):
            self._ranges.append(self._range)
            self._extremes.y_min, self._extremes.y_max, self._spring = math.inf, -math.inf, p

    @property
    def _range(self) -> SpringRange:
        return SpringRange(self._spring, self._extremes.y_min, self._extremes.y_max)

    def _record_switch(self, segment: Segment) -> None:
        if self._on_belt:
            self._mode_changes.append((segment.end, segment.mode, segment.next_mode))
        if segment.lifts_or_lands:
            self._switches.append(segment.end)
            self._separations += segment.mode in IN_CONTACT

    def _sample(self, times: NDArray[np.float64]) -> None:
        # Sample the stored segments, then discard them.
        solution = DenseSolution(self._request.system, self._segments)
        count = int(np.searchsorted(times, solution.t_end, side="right"))
        self._parts.append(solution(times[:count]))
        self._times = times[count:]
        self._segments = []
        if self._on_samples is not None and count > 0:
            self._on_samples(self._parts[-1])

    def result(self, kernel: Kernel | None = None) -> Transient:
        """The result of the run, without CPU time.

        Raises `ComputationError` if the contact force is beyond the floating-point range.
        """
        if self._times is not None and self._segments:
            self._sample(self._times)
        dense = self._request.dense
        return build_transient(
            self._request,
            final=self._final,
            extremes=self._extremes,
            ranges=[*self._ranges, self._range],
            second_half=self._second_half,
            switches=np.array(self._switches),
            separations=self._separations,
            separated_time=math.fsum(self._separated_durations),
            stats=Stats(steps=self._steps, kernel=kernel),
            first_mode=self._first_mode,
            changes=np.array(self._mode_changes) if self._mode_changes else NO_CHANGES,
            trajectory=Trajectory.joined(self._parts) if self._parts else None,
            solution=DenseSolution(self._request.system, self._segments) if dense else None,
        )

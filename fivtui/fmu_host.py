"""Transients through the FMU: fmpy is the master, this project's FMU the slave."""

import dataclasses
import heapq
import itertools
import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .core.columns import COLUMNS
from .core.errors import Cancelled, ComputationError
from .core.hermite import segment_between
from .core.methods import Problem
from .core.model import Mode, State
from .core.parameters import unknown_name
from .core.trajectory import Trajectory
from .core.transient import Progress, Recorder, Samples, Transient
from .fmu_instance import Messages, extracted, instantiated, interrupts_deferred

# Communication step, if none is given, and interval of interpolation in √(m/stiffness).
_STEP: Final = 0.05
_RESOLUTION: Final = 0.06
_MAX_STEPS: Final = 20_000_000
_PROGRESS_EVERY: Final = 128
_STATES: Final = ("x", "vx", "y", "vy")
_READ: Final = (*_STATES, "P", "mode", "separations", "reattachments", "last_event")


class _Point(NamedTuple):
    # What the FMU says at a communication point.
    t: float
    state: State
    P: float
    mode: Mode
    switches: int
    last_event: float


class _Slave:
    """The FMU as `integrate_fmu` uses it.

    Parameters
    ----------
    instance : FMU2Slave
        fmpy's instance.
    messages : Messages
        What it logs.
    description : ModelDescription
        Its variables.
    """

    def __init__(self, instance: Any, messages: Messages, description: Any) -> None:
        self._fmu = instance
        self._messages = messages
        self._references = {v.name: v.valueReference for v in description.modelVariables}
        self._read = [self._reference(name) for name in _READ]
        self.steps = 0

    def _reference(self, name: str) -> int:
        if name not in self._references:
            raise unknown_name("FMU variable", name, self._references)
        reference: int = self._references[name]
        return reference

    def begin(self, problem: Problem) -> _Point:
        """Initialize the FMU with a problem."""
        fmu = self._fmu
        reals = problem.parameters.as_dict()
        reals |= {f"{n}_start": value for n, value in zip(_STATES, problem.start, strict=True)}
        flags = {"separation": problem.separation, "start_static": False}
        fmu.setupExperiment(tolerance=problem.tol, startTime=0.0, stopTime=problem.t_end)
        fmu.setReal([self._reference(name) for name in reals], list(reals.values()))
        fmu.setBoolean([self._reference(name) for name in flags], list(flags.values()))
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        return self._point(0.0)

    def step(self, t: float, target: float) -> _Point:
        """Take a communication step."""
        from fmpy.fmi1 import FMICallException

        self.steps += 1
        try:
            self._fmu.doStep(t, target - t)
        except FMICallException:
            why, _, advice = (self._messages.last or "it says nothing").rpartition("; ")
            raise ComputationError(
                f"the FMU stops at t = {t:.6g} s: {why or advice}",
                advice if why else "check the FMU: fivtui fmu check",
            ) from None
        return self._point(target)

    def _point(self, t: float) -> _Point:
        x, vx, y, vy, force, mode, separations, reattachments, last = self._fmu.getReal(self._read)
        switches = int(separations) + int(reattachments)
        return _Point(t, (x, vx, y, vy), force, Mode(int(mode)), switches, last)

    def save(self) -> Any:
        """The FMU's state; to be given to `free`."""
        return self._fmu.getFMUstate()

    def restore(self, saved: Any) -> None:
        """Go back to a state."""
        self._fmu.setFMUstate(saved)

    def free(self, saved: Any) -> None:
        """Let a state go."""
        self._fmu.freeFMUstate(saved)

    def end(self) -> None:
        """Terminate the run."""
        self._fmu.terminate()


class _Master:
    # Drives the FMU, and makes segments of what it says: between communication points, switches
    # included, whose times and states are its own.

    def __init__(self, slave: _Slave, problem: Problem, recorder: Recorder) -> None:
        self._slave = slave
        self._problem = problem
        self._recorder = recorder
        self.point = slave.begin(problem)

    def move_to(self, target: float) -> None:
        """Take one communication step."""
        saved = self._slave.save()
        try:
            self.point = self._cover(saved, self.point, target)
        finally:
            self._slave.free(saved)

    def _cover(self, saved: Any, first: _Point, target: float) -> _Point:
        slave = self._slave
        last = slave.step(first.t, target)
        switches = last.switches - first.switches
        if switches > 1 or last.t - first.t > self._resolution(first, last):
            self._look_inside(saved, first, last)
            return last
        if switches == 0 or last.last_event >= last.t:
            self._include(first, last, switches=switches == 1)
            return last
        after = slave.save()
        try:
            slave.restore(saved)
            switch = slave.step(first.t, last.last_event)
            slave.restore(after)
        finally:
            slave.free(after)
        self._include(first, switch, switches=True)
        self._include(switch._replace(mode=last.mode), last, switches=False)
        return last

    def _look_inside(self, saved: Any, first: _Point, last: _Point) -> None:
        # The result does not depend on the communication step, so both halves meet in `last`.
        slave = self._slave
        middle = 0.5 * (first.t + last.t)
        if not first.t < middle < last.t:
            raise ComputationError(
                f"the motion at t = {first.t:.17g} s changes faster than the spacing of time",
                "use a less stiff contact or the taylor method",
            )
        after = slave.save()
        try:
            slave.restore(saved)
            half = self._cover(saved, first, middle)
            saved_half = slave.save()
            try:
                self._cover(saved_half, half, last.t)
            finally:
                slave.free(saved_half)
            slave.restore(after)
        finally:
            slave.free(after)

    def _resolution(self, first: _Point, last: _Point) -> float:
        # The longest interval over which interpolation is as good as the peaks are to be, s.
        p = self._problem.parameters
        stiffness = p.k1 + p.k2 + p.k3
        if Mode.CONTACT in (first.mode, last.mode):
            stiffness += 3.0 * p.k_nl * max(first.state[2] ** 2, last.state[2] ** 2)
        return _RESOLUTION * math.sqrt(p.m / stiffness)

    def _include(self, first: _Point, last: _Point, *, switches: bool) -> None:
        self._recorder.include(
            segment_between(
                self._problem.parameters,
                first.mode,
                (first.t, last.t),
                (first.state, last.state),
                switches=switches,
            )
        )


def integrate_fmu(
    problem: Problem,
    *,
    samples: Samples = "none",
    progress: Progress | None = None,
    fmu: Path | None = None,
) -> Transient:
    """Compute a transient through the FMU.

    Parameters
    ----------
    problem : Problem
        What to integrate; its `step` is the communication step, s. It changes no result: where it
        is too coarse for the peaks the master goes back and looks inside.
    samples : "none", "dense" or sequence of float
        What is kept of the trajectory. Sample times are communication points, where the trajectory
        holds the FMU's own outputs; "dense" interpolates between communication points.
    progress : callable, optional
        Called now and then with the fraction done; the run is cancelled when it returns False.
    fmu : Path, optional
        An FMU built by `fmu_src.builder.build_fmu`; a new one in a temporary folder if not given.

    Returns
    -------
    Transient
        States, and times and states of the switches, as the FMU gives them; peaks from fifth-order
        interpolation between communication points.

    Raises
    ------
    InputError
        If the sample times are wrong or `fmu` is not an FMU of this model.
    ComputationError
        If the FMU fails, with what it logged, or the step is too small for the horizon.
    Cancelled
        If `progress` returned False.
    """
    p = problem.parameters
    step = problem.step or _STEP * math.sqrt(p.m / (p.k1 + p.k2 + p.k3))
    if problem.t_end / step > _MAX_STEPS:
        raise ComputationError(
            f"{problem.t_end / step:.3g} communication steps of {step:g} s are needed",
            "use a larger step or a shorter horizon",
        )
    # The recorder checks the samples before any work.
    recorder = Recorder(problem, samples)
    times = None
    if not isinstance(samples, str):
        times = np.atleast_1d(np.asarray(samples, dtype=float))
        recorder = Recorder(problem)
    with ExitStack() as stack:
        check_interrupt = stack.enter_context(interrupts_deferred())
        if fmu is None:
            from fmu_src.builder import build_fmu

            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="fivtui-"))
            fmu = build_fmu(Path(folder) / "slider_belt.fmu")
        file = stack.enter_context(extracted(fmu))
        instance, messages = stack.enter_context(instantiated(file))
        slave = _Slave(instance, messages, file.description)
        master = _Master(slave, problem, recorder)
        kept = [master.point] if times is not None and times[0] == 0.0 else []
        wanted = frozenset(() if times is None else times.tolist())
        points = _communication_points(problem.t_end, step, () if times is None else times.tolist())
        for count, t in enumerate(points):
            if (
                count % _PROGRESS_EVERY == 0
                and progress
                and not progress(recorder.t / problem.t_end)
            ):
                raise Cancelled
            check_interrupt()
            master.move_to(t)
            if t in wanted:
                kept.append(master.point)
        slave.end()
    if progress:
        progress(1.0)
    result = recorder.result("fmu")
    return dataclasses.replace(
        result,
        stats=dataclasses.replace(result.stats, steps=slave.steps),
        trajectory=None if times is None else _trajectory(kept, times),
    )


def _communication_points(t_end: float, step: float, samples: Sequence[float]) -> Iterator[float]:
    # Multiples of the step and the sample times, each once, up to the horizon.
    grid = itertools.takewhile(
        lambda t: t < t_end - 1e-9 * step, (count * step for count in itertools.count(1))
    )
    last = 0.0
    for t in heapq.merge(grid, samples, [t_end]):
        if t > last:
            yield t
            last = t


def _trajectory(points: Sequence[_Point], times: NDArray[np.float64]) -> Trajectory:
    # One row for each time asked for, also where a time was asked for twice.
    rows = np.array([(p.t, *p.state, p.P, p.mode) for p in points])[
        np.searchsorted([p.t for p in points], times)
    ]
    columns = dict(zip((column.name for column in COLUMNS), rows.T, strict=True))
    columns["mode"] = columns["mode"].astype(np.int8)
    return Trajectory(**columns)

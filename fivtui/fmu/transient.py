"""Transients of the slider-belt computed by this project's FMU, run step by step through fmpy."""

import dataclasses
import heapq
import itertools
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from fivtui.io import temporary_folder, write_atomically
from fivtui.model import (
    COLUMNS,
    LINEAR_OVER_TIME,
    ComputationError,
    InputError,
    OnProgress,
    Progress,
    time_scale,
)
from fivtui.transient import (
    FMU_FLAVOURS,
    OnSamples,
    Recorder,
    Request,
    Trajectory,
    Transient,
)

from .instance import create_instance, defer_interrupts, extract_fmu
from .master import MAX_STEPS, Master, Point, Slave

# Default communication step, as a part of √(m/stiffness).
_STEP: Final = 0.05
# A multiple of the step this close to the end is the end, as a part of the step.
_END_TOLERANCE: Final = 1e-9
_STEPS_PER_REPORT: Final = 128
_SAMPLES_PER_CALL: Final = 256
_FMU_NAME: Final = "slider_belt.fmu"


@cache
def _fmu_content(flavour: str) -> bytes:
    """Content of an FMU of a flavour, "python" or "native" (in C).

    It is built once per process: building takes as long as a short run.
    """
    from fmu_src.build import build_fmu

    with temporary_folder() as folder:
        return build_fmu(folder / _FMU_NAME, flavour=flavour).read_bytes()


def integrate_fmu(
    request: Request,
    *,
    progress: OnProgress | None = None,
    on_samples: OnSamples | None = None,
    fmu: Path | None = None,
) -> Transient:
    """Compute a transient through the FMU in the file `fmu`, or one that is built for the run."""
    step = request.step or _STEP * time_scale(request.parameters)
    if request.t_end / step > MAX_STEPS:
        raise ComputationError(
            f"{request.t_end / step:.3g} communication steps of {step:g} s are needed",
            "use a larger step or a shorter horizon",
        )
    # Samples are outputs of the FMU; the recorder must not add interpolated ones.
    has_times = request.times is not None
    recorder = Recorder(dataclasses.replace(request, samples="none") if has_times else request)
    times: list[float] = [] if request.times is None else request.times.tolist()
    with ExitStack() as stack:
        check_interrupt = stack.enter_context(defer_interrupts())
        if fmu is None:
            fmu = stack.enter_context(temporary_folder()) / _FMU_NAME
            content = _fmu_content(FMU_FLAVOURS[request.method])

            def write(file: BinaryIO) -> None:
                file.write(content)

            write_atomically(fmu, write)
        file = stack.enter_context(extract_fmu(fmu))
        course = request.course
        inputs = [] if course is None else [n for n in LINEAR_OVER_TIME if n in course.tables]
        if inputs and not file.description.coSimulation.canInterpolateInputs:
            names = ", ".join(inputs)
            raise InputError(f"{names} over time: {fmu} does not accept derivatives of inputs")
        instance, messages = stack.enter_context(create_instance(file))
        reporter = Progress(progress)

        def before_step() -> None:
            check_interrupt()
            if slave.steps % _STEPS_PER_REPORT == 1:
                reporter.report(recorder.t / request.t_end)

        slave = Slave(instance, messages, file.description, before_step, course)
        master = Master(slave, request, recorder)
        points = [master.point] if times and times[0] == 0.0 else []
        sample_times = frozenset(times)
        # Slopes of inputs, and tunable parameters, change at the rows of their tables.
        kinks = [] if course is None else course.row_times_before(request.t_end)
        for t in _communication_points(request.t_end, step, [*heapq.merge(times, kinks)]):
            master.step_to(t)
            if t in sample_times:
                points.append(master.point)
                if on_samples is not None and len(points) % _SAMPLES_PER_CALL == 0:
                    samples = points[-_SAMPLES_PER_CALL:]
                    on_samples(_trajectory(samples, [point.t for point in samples]))
        slave.end()
    # Unlike `report`, `advance` does not raise `Cancelled`: the run is complete.
    reporter.advance(1.0)
    result = recorder.result()
    return dataclasses.replace(
        result,
        stats=dataclasses.replace(result.stats, steps=slave.steps),
        trajectory=_trajectory(points, times) if times else None,
    )


def _communication_points(t_end: float, step: float, times: Sequence[float]) -> Iterator[float]:
    # Multiples of the step merged with the given times, without repetition, up to the end.
    grid = itertools.takewhile(
        lambda t: t < t_end - _END_TOLERANCE * step, (count * step for count in itertools.count(1))
    )
    previous = 0.0
    for t in heapq.merge(grid, times, [t_end]):
        if t > previous:
            yield t
            previous = t


def _trajectory(points: Sequence[Point], times: Sequence[float]) -> Trajectory:
    # One row for each sample time, repeated times included.
    rows = np.array([(p.t, *p.state, p.P, p.mode) for p in points])[
        np.searchsorted([p.t for p in points], times)
    ]
    columns = dict(zip((column.name for column in COLUMNS), rows.T, strict=True))
    columns["mode"] = columns["mode"].astype(np.int8)
    return Trajectory(**columns)

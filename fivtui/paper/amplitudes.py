"""Amplitudes of many scenes at once, on all processors.

Taylor scenes run as a batch; runs by other methods are distributed among processes.
"""

import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from multiprocessing import get_context
from typing import Final

import numpy as np

from fivtui.batch import simulate_batch
from fivtui.model import Cancelled, ComputationError, InputError, OnProgress
from fivtui.scene import Scene
from fivtui.simulation import compute
from fivtui.transient import resolve_start

# Starting a process takes as long as some runs.
_RUNS_A_WORKER: Final = 16
_CHUNK: Final = 4


@dataclass(frozen=True, slots=True)
class Amplitude:
    """Vertical motion of a run: greatest |y| and half peak-to-peak of y, m; time off the belt, s.

    The half peak-to-peak is that over the second half of the run.
    """

    y_peak: float
    y_half_range: float
    separations: int
    separated_time: float


def measure(scene: Scene) -> Amplitude:
    """Amplitude of one scene; the same numbers as from `measure_all`."""
    return measure_all([scene], workers=1)[0]


def measure_all(
    scenes: Sequence[Scene], *, workers: int | None = None, progress: OnProgress | None = None
) -> list[Amplitude]:
    """Amplitudes of many scenes, in their order.

    `workers` is the greatest number of threads or processes, at least 1; the number of processors
    if not given. Raises `ComputationError` if a run cannot be finished or a worker process dies,
    and `Cancelled` if `progress`, called with the fraction done, returns False.
    """
    processors = os.cpu_count() or 1
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: must be at least 1")
    count = min(processors if workers is None else workers, processors)
    results: dict[int, Amplitude] = {}

    def report(fraction: float) -> bool:
        return progress is None or progress(min(fraction, 1.0))

    def group(place: int) -> tuple[bool, float, float]:
        scene = scenes[place]
        return scene.method == "taylor", scene.t_end, scene.tol

    for (batched, *_), members in groupby(sorted(range(len(scenes)), key=group), group):
        places = list(members)
        done, share = len(results) / len(scenes), len(places) / len(scenes)

        def part(fraction: float, done: float = done, share: float = share) -> bool:
            return report(done + share * fraction)

        some = [scenes[place] for place in places]
        found = _batched(some, count, part) if batched else _one_by_one(some, count, part)
        results.update(zip(places, found, strict=True))
    return [results[place] for place in range(len(scenes))]


def _batched(scenes: Sequence[Scene], workers: int, progress: OnProgress) -> list[Amplitude]:
    # Taylor scenes of equal length and tolerance.
    batch = simulate_batch(
        np.array([scene.parameters.values() for scene in scenes]),
        t_end=scenes[0].t_end,
        tol=scenes[0].tol,
        separation=np.array([scene.separation for scene in scenes]),
        start=np.array([resolve_start(s.system, s.start) for s in scenes]),
        require={"amplitude", "steady", "events"},
        workers=workers,
        progress=progress,
    )
    for place in batch.failed.tolist():
        error = batch.failure(place)
        if error is not None:
            raise _named(scenes[place], error)
    columns = (
        batch.amplitude.y_abs,
        batch.steady.y_half_range,
        batch.events.separations,
        batch.events.separated_time,
    )
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [Amplitude(*row) for row in rows]


def _named(scene: Scene, error: ComputationError) -> ComputationError:
    values = ", ".join(f"{k} = {v:g}" for k, v in scene.parameters.as_dict().items())
    return ComputationError(f"{scene.name} ({values}): {error.why}", error.advice)


def _one_by_one(scenes: Sequence[Scene], workers: int, progress: OnProgress) -> list[Amplitude]:
    results: list[Amplitude] = []
    with _mapped(scenes, min(workers, len(scenes) // _RUNS_A_WORKER)) as amplitudes:
        for amplitude in amplitudes:
            results.append(amplitude)
            if not progress(len(results) / len(scenes)):
                raise Cancelled
    return results


def _run(scene: Scene) -> Amplitude:
    try:
        run = compute(scene.request())
    except ComputationError as error:
        raise _named(scene, error) from None
    return Amplitude(
        y_peak=run.peak.y_abs,
        y_half_range=run.steady.y_half_range,
        separations=run.events.separations,
        separated_time=run.events.separated_time,
    )


@contextmanager
def _mapped(scenes: Sequence[Scene], count: int) -> Iterator[Iterator[Amplitude]]:
    if count < 2:
        yield map(_run, scenes)
        return
    # Spawned workers are the same on every system and inherit no threads.
    pool = ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=_ignore_interrupts
    )
    try:
        with _interrupts_ignored():
            amplitudes = pool.map(_run, scenes, chunksize=_CHUNK)
        yield amplitudes
    except BrokenProcessPool:
        raise ComputationError(
            "a worker process ended before its work was done",
            'start a script\'s work under if __name__ == "__main__", or use one worker',
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    # A terminal interrupts all processes; workers ignore that from their start, as they inherit
    # the signal handling set here. Only the main thread can set handlers.
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)

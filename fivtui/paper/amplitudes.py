"""Amplitudes of many scenes at once, on all processors."""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Final

from ..core.errors import Cancelled, ComputationError, InputError
from ..scene import Scene
from ..simulation import simulate

# Starting a process takes as long as some runs.
_RUNS_A_WORKER: Final = 16
_CHUNK: Final = 4

Progress = Callable[[float], bool]


@dataclass(frozen=True, slots=True)
class Amplitude:
    """What a run without trajectory says of its vertical motion.

    Attributes
    ----------
    y_peak : float
        Greatest |y|, m.
    y_half_range : float
        Half range of y over the second half of the horizon, m.
    separations : int
        Their number.
    separated_time : float
        Time off the belt, s.
    """

    y_peak: float
    y_half_range: float
    separations: int
    separated_time: float


def measure(scene: Scene) -> Amplitude:
    """Run one scene.

    Parameters
    ----------
    scene : Scene
        Any scene.

    Returns
    -------
    Amplitude
        Of its run.

    Raises
    ------
    ComputationError
        If the run cannot be finished.
    """
    try:
        run = simulate(
            scene.parameters,
            t_end=scene.t_end,
            tol=scene.tol,
            separation=scene.separation,
            start=scene.start,
            method=scene.method,
            step=scene.step,
            # The same numbers in every process, whichever kernel it has loaded.
            kernel="interpreted" if scene.method == "taylor" else "auto",
        )
    except ComputationError as error:
        values = ", ".join(f"{k} = {v:g}" for k, v in scene.parameters.as_dict().items())
        raise ComputationError(f"{scene.name} ({values}): {error.why}", error.advice) from None
    return Amplitude(
        y_peak=run.peak.y_abs,
        y_half_range=run.steady.y_half_range,
        separations=run.events.separations,
        separated_time=run.events.separated_time,
    )


def measure_all(
    scenes: Sequence[Scene], *, workers: int | None = None, progress: Progress | None = None
) -> list[Amplitude]:
    """Run many scenes, in several processes where they are enough to be worth it.

    Parameters
    ----------
    scenes : sequence of Scene
        The scenes.
    workers : int, optional
        Most processes, at least 1; as many as there are processors if not given.
    progress : callable, optional
        Called with the fraction done; the work is cancelled when it returns False.

    Returns
    -------
    list of Amplitude
        One a scene, in their order.

    Raises
    ------
    InputError
        If `workers` is less than 1.
    ComputationError
        If a run cannot be finished, or the worker processes end before their work.
    Cancelled
        If `progress` returned False.
    """
    processors = os.cpu_count() or 1
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: allowed is 1 or more")
    count = min(processors if workers is None else workers, processors)
    count = min(count, len(scenes) // _RUNS_A_WORKER)
    results: list[Amplitude] = []
    with _mapped(scenes, count) as amplitudes:
        for amplitude in amplitudes:
            results.append(amplitude)
            if progress is not None and not progress(len(results) / len(scenes)):
                raise Cancelled
    return results


@contextmanager
def _mapped(scenes: Sequence[Scene], count: int) -> Iterator[Iterator[Amplitude]]:
    if count < 2:
        yield map(measure, scenes)
        return
    # Spawned workers are the same on every system and inherit no threads.
    pool = ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=_ignore_interrupts
    )
    try:
        with _interrupts_ignored():
            amplitudes = pool.map(measure, scenes, chunksize=_CHUNK)
        yield amplitudes
    except BrokenProcessPool:
        raise ComputationError(
            "the worker processes ended before their work",
            'start a script\'s work under if __name__ == "__main__", or use one worker',
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    # A terminal interrupts all processes; workers leave it to this one, from their first moment:
    # they start inside, and inherit. Handlers belong to the main thread.
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)

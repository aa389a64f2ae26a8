"""Amplitudes of many scenes at once, as batches on all processors."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from fivtui.batch import simulate_batch
from fivtui.model import ComputationError, OnProgress, Progress
from fivtui.scene import Scene
from fivtui.transient import resolve_start


@dataclass(frozen=True, slots=True)
class Amplitude:
    """Vertical motion of a run: greatest |y| and half peak-to-peak of y, m; time off the belt, s.

    Half peak-to-peak is measured over the second half of the run.
    """

    y_peak: float
    y_half_range: float
    separations: int
    separated_time: float


def compute_amplitudes(
    scenes: Sequence[Scene], *, workers: int | None = None, progress: OnProgress | None = None
) -> list[Amplitude]:
    """Amplitudes of many scenes, in their order, by the Taylor method.

    `workers` is the greatest number of threads, at least 1; the number of processors if not given.
    Raises `ComputationError` if a run cannot be finished, and `Cancelled` if `progress`, called
    with the fraction done, returns False.
    """
    amplitudes: dict[int, Amplitude] = {}
    work = Progress(progress)

    def run_settings(index: int) -> tuple[float, float]:
        return scenes[index].t_end, scenes[index].tol

    # All scenes of a batch have the same horizon and tolerance.
    sorted_indices = sorted(range(len(scenes)), key=run_settings)
    for _, group in groupby(sorted_indices, run_settings):
        indices = list(group)
        begin = len(amplitudes) / len(scenes)
        end = (len(amplitudes) + len(indices)) / len(scenes)
        batch_progress = work.stage(begin, end).callback
        batch = _batch_amplitudes([scenes[index] for index in indices], workers, batch_progress)
        amplitudes.update(zip(indices, batch, strict=True))
    return [amplitudes[index] for index in range(len(scenes))]


def _batch_amplitudes(
    scenes: Sequence[Scene], workers: int | None, progress: OnProgress | None
) -> list[Amplitude]:
    """The amplitudes of scenes of equal length and tolerance."""
    batch = simulate_batch(
        np.array([scene.parameters.values() for scene in scenes]),
        t_end=scenes[0].t_end,
        tol=scenes[0].tol,
        separation=np.array([scene.separation for scene in scenes]),
        start=np.array([resolve_start(s.system, s.start) for s in scenes]),
        # "steady" is half peak-to-peak over the second half of the run.
        require={"amplitude", "steady", "events"},
        workers=workers,
        progress=progress,
    )
    if batch.failed.size:
        index = int(batch.failed[0])
        scene, error = scenes[index], batch.failure(index)
        assert error is not None  # noqa: S101
        parameters = scene.parameters.as_dict().items()
        values = ", ".join(f"{name} = {value:g}" for name, value in parameters)
        raise ComputationError(f"{scene.name} ({values}): {error.why}", error.advice)
    columns = (
        batch.amplitude.y_abs,
        batch.steady.y_half_range,
        batch.events.separations,
        batch.events.separated_time,
    )
    return [Amplitude(*row) for row in zip(*(c.tolist() for c in columns), strict=True)]

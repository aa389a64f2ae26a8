"""The runs of a session. Imports no Textual.

The plots show the displayed run and the overlaid runs; numbers are compared with the baseline.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import series_role
from fivtui.model import ComputationError, equilibrium, time_scale
from fivtui.scene import Scene, scene_transient
from fivtui.transient import FMU_FLAVOURS, OnSamples, Trajectory, Transient, uses_step

from .jobs import Job, Outcome, compute_outcome

# Maximum number of runs in the list.
MAX_RUNS: Final = 20
# Displayed name of the native engine, and of the engines of methods that run an FMU.
NATIVE_ENGINE: Final = "native"
FMU_ENGINES: Final = {
    method: f"{flavour.capitalize() if flavour == 'python' else flavour} FMU"
    for method, flavour in FMU_FLAVOURS.items()
}
# Number of samples per shortest natural period, and limits of their number per run.
_SAMPLES_PER_PERIOD: Final = 64
_MIN_SAMPLES: Final = 1000
_MAX_SAMPLES: Final = 250_000
# Characters that mark the runs.
MARKERS: Final = "●■▲◆▼★"


def engine_of(method: str) -> str:
    """The engine of a method: ``native``, ``Python FMU`` or ``native FMU``."""
    return FMU_ENGINES.get(method, NATIVE_ENGINE)


class RunState(Enum):
    """State of a run, as displayed."""

    RUNNING = "running"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"
    # Done, but its result was not stored with the session or cannot be read.
    NOT_KEPT = "not kept"


@dataclass(eq=False, slots=True)
class Run(Job):
    """A transient of a session."""

    # From 1.
    number: int
    scene: Scene
    state: RunState = RunState.RUNNING
    result: Transient | None = None
    # Error message of a failed run.
    message: str = ""
    # The scene of the form if engines are compared: `scene` may differ in method and step.
    edited_scene: Scene | None = None
    # The file from which the run was read.
    source: str = ""
    # Whether the run is plotted beside the displayed one.
    overlaid: bool = False
    # Numbers of colours and of markers by which its style is beyond that of its number.
    colour_shift: int = 0
    marker_shift: int = 0
    # Parts of the trajectory so far, from the computing thread.
    _parts: list[Trajectory] = field(default_factory=list)

    @property
    def look(self) -> tuple[str, str]:
        """Marker and role of the colour; six markers and seven colours repeat after 42 runs."""
        marker, colour = self.number - 1 + self.marker_shift, self.number - 1 + self.colour_shift
        return MARKERS[marker % len(MARKERS)], series_role(colour)

    def __str__(self) -> str:
        return self.name

    @property
    def name(self) -> str:
        """Its name in legends and messages."""
        return f"run {self.number}"

    @property
    def engine(self) -> str:
        """The engine of its method, or ``file`` if the run was read from a file."""
        return "file" if self.source else engine_of(self.scene.method)

    def add_part(self, part: Trajectory) -> None:
        """Add a part of the trajectory; one that overlaps the last starts a new trajectory."""
        if self._parts and part.t[0] <= self._parts[-1].t[-1]:
            self._parts = []
        self._parts.append(part)

    @property
    def trajectory_so_far(self) -> Trajectory | None:
        """The trajectory of a run in progress; None before the first part."""
        parts = self._parts.copy()
        return Trajectory.joined(parts) if parts else None

    def report(self, fraction: float) -> bool:
        """As `Job.report`; progress starts again when a second run verifies the accuracy."""
        # `Job.report` never reduces the fraction.
        self.fraction = min(self.fraction, fraction)
        return Job.report(self, fraction)

    @property
    def accuracy_text(self) -> str:
        """Describes the requested accuracy."""
        scene = self.scene
        if self.source:
            return f"read from {self.source}: extrema are those of its samples"
        if scene.accuracy:
            return "error of " + ", ".join(f"{name} {error:g}" for name, error in scene.accuracy)
        if uses_step(scene.method):
            step = "default step" if scene.step is None else f"step {scene.step:g} s"
            return f"{step}, error not controlled"
        return f"tol {scene.tol:g}"


def sample_times(scene: Scene) -> NDArray[np.float64]:
    """0, the multiples of an interval, and the end time, s: 1000 to 250 000 samples.

    The interval, 1, 2 or 5 times a power of ten, is at most 1/64 of the shortest natural period.
    """
    try:
        y = equilibrium(scene.system).y
    except ComputationError:
        y = 0.0
    # 1 / `time_scale` is an upper bound of the natural angular frequencies.
    max_interval = math.tau * time_scale(scene.parameters, y) / _SAMPLES_PER_PERIOD
    # Rounding divides an interval by less than 2.5.
    min_interval = 2.5 * scene.t_end / _MAX_SAMPLES
    limit = max(min(max_interval, scene.t_end / _MIN_SAMPLES), min_interval)
    decade = Fraction(10) ** math.floor(math.log10(limit))
    digits = (Fraction(1, 2), 1, 2, 5, 10)
    interval = max(decade * digit for digit in digits if decade * digit <= limit)
    count = math.floor(scene.t_end / interval) + 1
    # Multiplying first gives exact decimal times.
    times = np.arange(count) * float(interval.numerator) / float(interval.denominator)
    return np.append(times[times < scene.t_end], scene.t_end)


def execute(run: Run) -> Outcome[Transient]:
    """Compute a run in the calling thread; `Runs.finish` stores the outcome."""
    return compute_scene(run.scene, run, run.add_part)


def compute_scene(
    scene: Scene, job: Job, on_samples: OnSamples | None = None
) -> Outcome[Transient]:
    """Compute the transient of a scene in the calling thread, with its progress in a job."""
    samples = sample_times(scene)
    return compute_outcome(
        lambda: (
            scene_transient(
                scene, samples=samples, progress=job.report, on_samples=on_samples
            ).transient
        )
    )


class Runs:
    """The runs of a session, newest last; at most one is active.

    `count` is the number of the newest run, even if it was deleted.
    """

    def __init__(self, runs: Iterable[Run] = (), count: int = 0) -> None:
        self.displayed: Run | None = None
        self.baseline: Run | None = None
        self.count = count
        self._runs = list(runs)

    def __iter__(self) -> Iterator[Run]:
        return iter(self._runs)

    @property
    def newest(self) -> Run | None:
        """The newest run."""
        return self._runs[-1] if self._runs else None

    @property
    def active(self) -> Run | None:
        """The run in progress."""
        return next((run for run in self._runs if run.state is RunState.RUNNING), None)

    def start(self, scene: Scene, edited_scene: Scene | None = None) -> Run:
        """Add a run, to be computed by `execute`; stops the active run."""
        self.stop()
        return self._add(scene, edited_scene=edited_scene)

    def _add(self, scene: Scene, **attributes: Any) -> Run:
        self.count += 1
        run = Run(self.count, scene, **attributes)
        self._runs.append(run)
        while len(self._runs) > MAX_RUNS:
            # Remove the oldest run without a result, or else the oldest.
            used_runs = (self.displayed, self.baseline, self.active, run)
            unused = [old_run for old_run in self._runs if old_run not in used_runs]
            self.remove(min(unused, key=lambda run: run.state is RunState.DONE))
        return run

    def add_loaded(self, scene: Scene, result: Transient, source: str) -> Run:
        """Add a run read from a file: overlaid, or displayed if no run is displayed."""
        run = self._add(scene, state=RunState.DONE, result=result, source=source, overlaid=True)
        self.displayed = self.displayed or run
        return run

    def remove(self, run: Run) -> None:
        """Stop and delete a run. If it is displayed, the newest run with a result replaces it."""
        if run is self.active:
            self.stop()
        # Redo may delete a run that was already removed because the list was full.
        if run in self._runs:
            self._runs.remove(run)
        if self.baseline is run:
            self.baseline = None
        if self.displayed is run:
            finished = (run for run in reversed(self._runs) if run.result is not None)
            self.displayed = next(finished, None)

    def reinsert(self, run: Run) -> None:
        """Restore a deleted run at its position in the order of numbers."""
        self._runs.append(run)
        self._runs.sort(key=lambda member: member.number)

    @property
    def plotted(self) -> list[Run]:
        """The runs to plot: overlaid runs with results, then the displayed one."""
        overlaid = [run for run in self._runs if run.overlaid and run is not self.displayed]
        plotted = overlaid if self.displayed is None else [*overlaid, self.displayed]
        return [run for run in plotted if run.result is not None]

    def stop(self) -> Run | None:
        """Stop the active run at once and return it."""
        run = self.active
        if run is not None:
            run.state = RunState.STOPPED
            run.stop()
        return run

    def finish(self, run: Run, outcome: Outcome[Transient]) -> bool:
        """Store a run's outcome. Returns False if the run was stopped before."""
        if run.state is not RunState.RUNNING:
            return False
        run.result, run.message = outcome.result, outcome.error
        run.state = RunState.DONE if outcome.result is not None else RunState.FAILED
        run._parts = []
        return True

    def find(self, number: int) -> Run | None:
        """The run with this number; None if it was deleted."""
        return next((run for run in self._runs if run.number == number), None)

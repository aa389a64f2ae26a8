"""The runs of a session. Imports no Textual.

The plots show the displayed run and the overlaid runs; numbers are compared with the baseline.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from typing import Final

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


# States without a result.
_NO_RESULT: Final = (RunState.STOPPED, RunState.FAILED, RunState.NOT_KEPT)


@dataclass(slots=True)
class RunStyle:
    """Colour and marker of a run: indices of a series and of `MARKERS`, modulo their numbers."""

    colour: int
    marker: int

    @property
    def colour_role(self) -> str:
        """The role of the colour."""
        return series_role(self.colour)

    @property
    def marker_sign(self) -> str:
        """The marker character."""
        return MARKERS[self.marker % len(MARKERS)]

    @property
    def look(self) -> tuple[str, str]:
        """Marker and role of the colour."""
        return self.marker_sign, self.colour_role


def default_style(number: int) -> RunStyle:
    """The default style of run `number`: seven colours and six markers repeat after 42 runs."""
    return RunStyle(number - 1, number - 1)


class PartialTrajectory:
    """Collects parts of a trajectory from the computing thread; the screen's thread reads them."""

    def __init__(self) -> None:
        self._parts: list[Trajectory] = []

    def append(self, part: Trajectory) -> None:
        """Append a part; a part that overlaps the last one starts a new trajectory."""
        if self._parts and part.t[0] <= self._parts[-1].t[-1]:
            self._parts = []
        self._parts.append(part)

    def trajectory(self) -> Trajectory | None:
        """The trajectory so far; None before the first part."""
        # The computing thread may append to the list or replace it meanwhile.
        parts = self._parts
        count = len(parts)
        if count > 1:
            parts[:count] = [Trajectory.joined(parts[:count])]
        return parts[0] if parts else None


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
    style: RunStyle = field(init=False)
    # The trajectory so far.
    partial: PartialTrajectory = field(default_factory=PartialTrajectory)

    def __post_init__(self) -> None:
        self.style = default_style(self.number)

    @property
    def name(self) -> str:
        """Its name in legends and messages."""
        return f"run {self.number}"

    @property
    def engine(self) -> str:
        """The engine of its method, or ``file`` if the run was read from a file."""
        return "file" if self.source else engine_of(self.scene.method)

    @property
    def form_scene(self) -> Scene:
        """The scene of the form when the run was started."""
        return self.edited_scene or self.scene

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


def sample_interval(scene: Scene) -> Fraction:
    """Sampling interval, s, of at most 1/64 of the shortest natural period.

    It is 1, 2 or 5 times a power of ten, and yields 1000 to 250 000 samples.
    """
    parameters = scene.parameters
    try:
        y = equilibrium(scene.system).y
    except ComputationError:
        y = 0.0
    # 1 / `time_scale` is an upper bound of the natural angular frequencies.
    max_interval = math.tau * time_scale(parameters, y) / _SAMPLES_PER_PERIOD
    interval = _round_interval(min(max_interval, scene.t_end / _MIN_SAMPLES), up=False)
    min_interval = scene.t_end / _MAX_SAMPLES
    return interval if interval >= min_interval else _round_interval(min_interval, up=True)


def sample_times(scene: Scene) -> NDArray[np.float64]:
    """0, the multiples of `sample_interval`, and the end time, s."""
    interval = sample_interval(scene)
    count = math.floor(scene.t_end / interval) + 1
    # Multiplying first gives exact decimal times.
    times = np.arange(count) * float(interval.numerator) / float(interval.denominator)
    return np.append(times[times < scene.t_end], scene.t_end)


def _round_interval(value: float, *, up: bool) -> Fraction:
    # Round to 1, 2 or 5 times a power of ten.
    decade = Fraction(10) ** math.floor(math.log10(value))
    intervals = [decade * digit for digit in (Fraction(1, 2), 1, 2, 5, 10, 20)]
    if up:
        return min(interval for interval in intervals if interval >= value)
    return max(interval for interval in intervals if interval <= value)


def execute(run: Run) -> Outcome[Transient]:
    """Compute a run in the calling thread; `Runs.finish` stores the outcome."""
    return compute_scene(run.scene, run, run.partial.append)


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
    """The runs of a session, newest last; at most one is active."""

    def __init__(self) -> None:
        self.displayed: Run | None = None
        self.baseline: Run | None = None
        self._runs: list[Run] = []
        self._removed: dict[int, Run] = {}
        self._count = 0

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

    @property
    def count(self) -> int:
        """The number of the newest run, even if it was deleted."""
        return self._count

    def restore(self, runs: Iterable[Run], count: int) -> None:
        """Insert the runs of a saved session before all others; `count` is its `Runs.count`."""
        self._runs[:0] = runs
        self._count = max(count, self._count, *(run.number for run in self._runs), 0)

    def start(self, scene: Scene, edited_scene: Scene | None = None) -> Run:
        """Add a run, to be computed by `execute`; stops the active run."""
        self.stop()
        run = self._add(scene)
        run.edited_scene = edited_scene
        return run

    def _add(self, scene: Scene) -> Run:
        self._count += 1
        run = Run(self._count, scene)
        self._runs.append(run)
        while len(self._runs) > MAX_RUNS:
            # Remove the oldest run without a result, or else the oldest.
            used_runs = (self.displayed, self.baseline, self.active, run)
            unused = [old_run for old_run in self._runs if old_run not in used_runs]
            without_result = [old_run for old_run in unused if old_run.state in _NO_RESULT]
            self.remove([*without_result, *unused][0])
        return run

    def add_loaded(self, scene: Scene, result: Transient, source: str) -> Run:
        """Add a run read from a file: overlaid, or displayed if no run is displayed."""
        run = self._add(scene)
        run.state, run.result, run.source, run.overlaid = RunState.DONE, result, source, True
        if self.displayed is None:
            self.displayed = run
        return run

    def remove(self, run: Run) -> None:
        """Stop and delete a run. If it is displayed, the newest run with a result replaces it."""
        if run is self.active:
            self.stop()
        self._runs.remove(run)
        if self.baseline is run:
            self.baseline = None
        if self.displayed is run:
            finished = [candidate for candidate in self._runs if candidate.result is not None]
            self.displayed = finished[-1] if finished else None

    def remove_restorably(self, run: Run) -> None:
        """Delete a run so that `reinsert` can restore it."""
        self.remove(run)
        self._removed[run.number] = run
        if len(self._removed) > MAX_RUNS:
            del self._removed[next(iter(self._removed))]

    def reinsert(self, run: Run) -> None:
        """Restore a deleted run at its place in the order of numbers."""
        self._removed.pop(run.number, None)
        self._runs.append(run)
        self._runs.sort(key=lambda member: member.number)

    @property
    def plotted(self) -> list[Run]:
        """The runs to plot: overlaid runs with results, then the displayed one."""
        overlaid = [
            run
            for run in self._runs
            if run.overlaid and run.result is not None and run is not self.displayed
        ]
        if self.displayed is None or self.displayed.result is None:
            return overlaid
        return [*overlaid, self.displayed]

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
        run.partial = PartialTrajectory()
        return True

    def find(self, number: int) -> Run | None:
        """The run with this number; None if it was deleted."""
        return next((run for run in self._runs if run.number == number), None)

    def find_with_removed(self, number: int) -> Run | None:
        """The run with this number, including deleted runs that `reinsert` can restore."""
        return self.find(number) or self._removed.get(number)

"""Runs of a session: numbered, stoppable, stale results dropped. Imports no Textual."""

import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.scene.run import scene_transient
from fivtui.scene.scene import Scene
from fivtui.transient.methods import takes_step
from fivtui.transient.result import Transient

from .growth import Growth
from .jobs import PRECEDENCE
from .run_styles import RunStyle, usual_style
from .sampling import sample_times

MAX_RUNS: Final = 20
FMU_METHOD: Final = "fmu"
FMU_ENGINE: Final = "FMU"


def engine_of(method: str) -> str:
    """What runs a method: ``native`` or ``FMU``."""
    return FMU_ENGINE if method == FMU_METHOD else "native"


class RunState(Enum):
    """Where a run stands, in words."""

    RUNNING = "running"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"
    NOT_KEPT = "not kept"


# Of these there is no result, nor will there be one.
_WITHOUT: Final = (RunState.STOPPED, RunState.FAILED, RunState.NOT_KEPT)


@dataclass(eq=False, slots=True)
class Run:
    """One transient of a session.

    Attributes
    ----------
    number : int
        From 1, never used twice.
    scene : Scene
        What is computed.
    state : RunState
        Set by the side that shows it, never by the computing thread.
    fraction : float
        Part done, 0 to 1; written by the computing thread.
    result : Transient or None
        What came out of it.
    message : str
        Why it failed.
    edited : Scene or None
        What the fields said when it began, where that is not the scene: the other engine's.
    source : str
        File that it was read from; empty if it was computed here.
    overlaid : bool
        Whether it is drawn beside the run shown.
    style : RunStyle
        Colour and marker.
    growth : Growth
        Its trajectory so far, while it goes on.
    """

    number: int
    scene: Scene
    state: RunState = RunState.RUNNING
    fraction: float = 0.0
    result: Transient | None = None
    message: str = ""
    edited: Scene | None = None
    source: str = ""
    overlaid: bool = False
    style: RunStyle = field(init=False)
    growth: Growth = field(default_factory=Growth)
    _begin: float = field(default_factory=time.monotonic)
    _stop: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self.style = usual_style(self.number)

    @property
    def engine(self) -> str:
        """What computed it: ``native``, ``FMU``, or ``file``."""
        return "file" if self.source else engine_of(self.scene.method)

    def report(self, fraction: float) -> bool:
        """Take note of progress; whether to go on. Called by the computing thread."""
        self.fraction = fraction
        PRECEDENCE.give_way()
        return not self._stop.is_set()

    def ask_to_stop(self) -> None:
        """Let the computing thread know that nobody waits for it any more."""
        self._stop.set()

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._begin

    @property
    def remaining(self) -> float | None:
        """Seconds still to go at the mean speed so far; None while that is unknown."""
        if self.fraction <= 0.0:
            return None
        return self.elapsed * (1.0 - self.fraction) / self.fraction

    @property
    def accuracy(self) -> str:
        """The accuracy asked for, in words."""
        scene = self.scene
        if self.source:
            return f"read from {self.source}: extremes are those of its samples"
        if scene.accuracy:
            return "error of " + ", ".join(f"{name} {error:g}" for name, error in scene.accuracy)
        if takes_step(scene.method):
            step = "default step" if scene.step is None else f"step {scene.step:g} s"
            return f"{step}, error not controlled"
        return f"tol {scene.tol:g}"


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the computation of a run ended: a result, or an error, or neither when stopped."""

    result: Transient | None = None
    error: str = ""


def execute(run: Run) -> Outcome:
    """Compute a run in the calling thread.

    Parameters
    ----------
    run : Run
        The run; only its progress is written.

    Returns
    -------
    Outcome
        To be given to `Runs.finish` by the thread that shows the run.
    """
    scene = run.scene
    try:
        result = scene_transient(
            scene,
            samples=sample_times(scene),
            progress=run.report,
            on_samples=run.growth.take,
        ).transient
    except Cancelled:
        return Outcome()
    except (InputError, ComputationError) as error:
        return Outcome(error=str(error))
    return Outcome(result)


class Runs:
    """The runs of a session, newest last; at most one is running.

    Attributes
    ----------
    shown : Run or None
        The run whose result is shown.
    baseline : Run or None
        The run that others are compared with.
    """

    def __init__(self) -> None:
        self.shown: Run | None = None
        self.baseline: Run | None = None
        self._runs: list[Run] = []
        self._count = 0

    def __iter__(self) -> Iterator[Run]:
        return iter(self._runs)

    @property
    def newest(self) -> Run | None:
        """The run started last."""
        return self._runs[-1] if self._runs else None

    @property
    def active(self) -> Run | None:
        """The run that is running."""
        return next((run for run in self._runs if run.state is RunState.RUNNING), None)

    @property
    def count(self) -> int:
        """The number used last."""
        return self._count

    def restore(self, runs: Iterable[Run], count: int) -> None:
        """Put runs of an earlier session before those of this one.

        Parameters
        ----------
        runs : iterable of Run
            The oldest first.
        count : int
            The number used last.
        """
        self._runs[:0] = runs
        self._count = max(count, self._count, *(run.number for run in self._runs), 0)

    def start(self, scene: Scene, edited: Scene | None = None) -> Run:
        """Begin a new run, stopping the one that is running.

        Parameters
        ----------
        scene : Scene
            What to compute.
        edited : Scene, optional
            See `Run`.

        Returns
        -------
        Run
            To be given to `execute` in a thread.
        """
        self.stop()
        run = self._add(scene)
        run.edited = edited
        return run

    def _add(self, scene: Scene) -> Run:
        self._count += 1
        run = Run(self._count, scene)
        self._runs.append(run)
        while len(self._runs) > MAX_RUNS:
            kept = (self.shown, self.baseline, self.active, run)
            others = [old for old in self._runs if old not in kept]
            self.remove(next((old for old in others if old.state in _WITHOUT), others[0]))
        return run

    def take_in(self, scene: Scene, result: Transient, source: str) -> Run:
        """Add a run that was read from a file; a run that goes on here goes on.

        Parameters
        ----------
        scene : Scene
            What was computed.
        result : Transient
            What came out of it.
        source : str
            The file.

        Returns
        -------
        Run
            Drawn beside the run shown, or shown if there is none.
        """
        run = self._add(scene)
        run.state, run.result, run.source, run.overlaid = RunState.DONE, result, source, True
        if self.shown is None:
            self.shown = run
        return run

    def remove(self, run: Run) -> None:
        """Forget a run; if it is running it is stopped.

        Parameters
        ----------
        run : Run
            The run. If it was shown, the newest result takes its place.
        """
        if run is self.active:
            self.stop()
        self._runs.remove(run)
        if self.baseline is run:
            self.baseline = None
        if self.shown is run:
            done = [other for other in self._runs if other.result is not None]
            self.shown = done[-1] if done else None

    @property
    def drawn(self) -> list[Run]:
        """The runs to draw, that shown last: all that are overlaid, each with a result."""
        beside = [
            run
            for run in self._runs
            if run.overlaid and run.result is not None and run is not self.shown
        ]
        if self.shown is None or self.shown.result is None:
            return beside
        return [*beside, self.shown]

    def stop(self) -> Run | None:
        """Stop the run that is running, at once for whoever looks at it.

        Returns
        -------
        Run or None
            The run stopped.
        """
        run = self.active
        if run is not None:
            run.state = RunState.STOPPED
            run.ask_to_stop()
        return run

    def finish(self, run: Run, outcome: Outcome) -> bool:
        """Take in how a computation ended.

        Parameters
        ----------
        run : Run
            The run.
        outcome : Outcome
            How it ended.

        Returns
        -------
        bool
            False if the run was stopped before: its outcome is stale and dropped.
        """
        if run.state is not RunState.RUNNING:
            return False
        run.result, run.message = outcome.result, outcome.error
        run.state = RunState.DONE if outcome.result is not None else RunState.FAILED
        run.growth = Growth()
        return True

    def find(self, number: int) -> Run | None:
        """The run of that number, if it is still kept."""
        return next((run for run in self._runs if run.number == number), None)

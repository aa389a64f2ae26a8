"""The live curve: a run of the edited scene that is not kept. Imports no Textual."""

from collections.abc import Hashable
from dataclasses import dataclass
from enum import Enum
from typing import Final

from fivtui.scene import Scene, scene_transient
from fivtui.transient import METHODS, Transient

from .jobs import Job, Outcome, duration_text, outcome_of
from .runs import sample_times

# A shorter run follows every edit, a longer one a pause; beyond the second there is none, s.
AT_ONCE_S: Final = 0.1
LONGEST_S: Final = 15.0
_FASTEST: Final = next(iter(METHODS))
# Fractions: of a first part, and too little to tell how long the rest takes.
_FIRST: Final = 0.2
_LITTLE: Final = 0.01


class Pace(Enum):
    """When the live curve follows an edit."""

    AT_ONCE = "at once"
    IDLE = "when idle"
    OFF = "off"


@dataclass(eq=False, slots=True, kw_only=True)
class LiveJob(Job):
    """A run for the live curve; it ends itself when it takes too long."""

    scene: Scene
    pace: Pace
    setup: float = 0.0
    duration: float = 0.0

    def report(self, fraction: float) -> bool:
        """As `Job.report`. Returns False also after the longest time."""
        if not self.setup and fraction < _FIRST:
            self.setup = self.elapsed
        return Job.report(self, fraction) and self.elapsed - self.setup < LONGEST_S

    @property
    def estimate(self) -> float:
        """How long a whole run takes, s, from what is done of it; if that is little, at least."""
        done = self.fraction if self.fraction > _LITTLE else 1.0
        return (self.elapsed - self.setup) / done


@dataclass(frozen=True, slots=True, eq=False)
class LiveRun:
    """A result that is not kept, its scene, and how long it took, s."""

    scene: Scene
    result: Transient
    duration: float


class Live:
    """The live curve, the one before it, and how long runs take."""

    def __init__(self) -> None:
        self.curve: LiveRun | None = None
        self.ghost: Transient | None = None
        self.words = self.error = ""
        # Seconds of a run per second of its scene, by what decides about it.
        self._rates: dict[Hashable, float] = {}

    @property
    def shown(self) -> bool:
        """Whether the live curve, or the one before it, is plotted in place of a kept run."""
        return self.curve is not None or self.ghost is not None

    def learn(self, scene: Scene, seconds: float) -> None:
        """Take note of how long a run took."""
        self._rates[_kind(scene)] = seconds / scene.t_end

    def expected(self, scene: Scene) -> float | None:
        """How long a run of a scene takes, s; None if none like it has been measured."""
        rate = self._rates.get(_kind(scene))
        return None if rate is None else rate * scene.t_end

    def pace(self, scene: Scene) -> Pace:
        """When to run a scene. Without a measurement a compiled run is taken to be short."""
        seconds = self.expected(scene)
        if seconds is None:
            fast = scene.method == _FASTEST and not scene.over_time
            return Pace.AT_ONCE if fast else Pace.IDLE
        if seconds < AT_ONCE_S:
            return Pace.AT_ONCE
        return Pace.IDLE if seconds < LONGEST_S else Pace.OFF

    def put(self, run: LiveRun, before: Transient | None) -> None:
        """Show a result; the one shown before, or else `before`, becomes the ghost."""
        self.ghost = self._before(before)
        self.curve, self.error = run, ""
        self.words = f"live in {_short(run.duration)}; F5 keeps a run"

    def fail(self, error: str, before: Transient | None) -> None:
        """Leave the ghost alone, and say why."""
        self.ghost, self.curve = self._before(before), None
        self.words, self.error = "live: no result", error

    def _before(self, other: Transient | None) -> Transient | None:
        if self.curve is not None:
            return self.curve.result
        return other if self.ghost is None else self.ghost

    def clear(self, words: str = "") -> None:
        """Show kept runs alone."""
        self.curve = self.ghost = None
        self.words, self.error = words, ""

    def wait(self, scene: Scene) -> None:
        """Say that a run will follow a pause."""
        seconds = self.expected(scene)
        about = " when idle" if seconds is None else f" in about {_short(seconds)}"
        self.words = f"live: follows{about}"

    def refuse(self, scene: Scene) -> None:
        """Say that a run would take too long, and show kept runs alone."""
        seconds = self.expected(scene)
        about = "" if seconds is None else f", a run takes {duration_text(seconds)}"
        self.clear(f"live off{about}: F5 runs")


def execute_live(job: LiveJob) -> Outcome[Transient]:
    """Compute the run of a live job in the calling thread."""
    scene = job.scene
    return outcome_of(
        lambda: scene_transient(scene, samples=sample_times(scene), progress=job.report).transient
    )


def _kind(scene: Scene) -> Hashable:
    finite = scene.parameters.v_belt is not None
    return scene.method, scene.separation, bool(scene.accuracy), finite, bool(scene.over_time)


def _short(seconds: float) -> str:
    return f"{1e3 * seconds:.2g} ms" if seconds < AT_ONCE_S else f"{seconds:.2g} s"

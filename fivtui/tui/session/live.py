"""The live curve: a run of the edited scene that is not kept. Imports no Textual.

Its ghost is the curve before the last edit, for comparison.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Final

from fivtui.scene import Scene
from fivtui.transient import METHODS, Transient

from .jobs import Job, duration_text

# Longest duration of a run that follows every edit, and of one that follows a pause, s.
MAX_IMMEDIATE_S: Final = 0.1
MAX_LIVE_S: Final = 15.0
_FASTEST_METHOD: Final = next(iter(METHODS))
# A first report of less progress than this marks the end of the setup, such as loading libraries.
_MAX_FIRST_PROGRESS: Final = 0.2
# Least progress from which the duration of a run is extrapolated.
_MIN_PROGRESS: Final = 0.01


class Pace(Enum):
    """When an edit updates the live curve."""

    AT_ONCE = "at once"
    IDLE = "when idle"
    OFF = "off"


@dataclass(eq=False, slots=True, kw_only=True)
class LiveJob(Job):
    """A run for the live curve; it stops after `MAX_LIVE_S`.

    `setup_time` precedes the first progress, `duration` is measured at the end, both in s.
    """

    scene: Scene
    pace: Pace
    setup_time: float = 0.0
    duration: float = 0.0

    def report(self, fraction: float) -> bool:
        """As `Job.report`. Returns False also after `MAX_LIVE_S`."""
        # The first report ends the setup, whose time is then no longer 0.
        if self.setup_time == 0.0 and fraction < _MAX_FIRST_PROGRESS:
            self.setup_time = self.elapsed
        return Job.report(self, fraction) and self.elapsed - self.setup_time < MAX_LIVE_S

    @property
    def estimated_duration(self) -> float:
        """Duration of the complete run, s, extrapolated from its progress."""
        fraction = self.fraction if self.fraction > _MIN_PROGRESS else 1.0
        return (self.elapsed - self.setup_time) / fraction


@dataclass(frozen=True, slots=True, eq=False)
class LiveRun:
    """The run that the live curve shows: its scene, result, and computing time, s."""

    name: ClassVar[str] = "live"
    scene: Scene
    result: Transient
    duration: float


class LiveCurve:
    """The live curve; its ghost, which is the previous curve; and measured durations of runs."""

    def __init__(self) -> None:
        self.curve: LiveRun | None = None
        self.ghost: Transient | None = None
        self.status = self.error = ""
        # Whether the plots will show another scene as soon as the inputs are valid and computed.
        self.is_outdated = False
        # Computing time per simulated second, by `_scene_kind`.
        self._rates: dict[Hashable, float] = {}

    @property
    def visible(self) -> bool:
        """Whether the plots show the live curve or its ghost in place of the displayed run."""
        return self.curve is not None or self.ghost is not None

    def record_duration(self, scene: Scene, seconds: float) -> None:
        """Record the duration of a run."""
        self._rates[_scene_kind(scene)] = seconds / scene.t_end

    def expected_duration(self, scene: Scene) -> float | None:
        """Expected duration of a run, s; None if no run of this kind of scene was measured."""
        rate = self._rates.get(_scene_kind(scene))
        return None if rate is None else rate * scene.t_end

    def pace(self, scene: Scene) -> Pace:
        """When to run an edited scene, from the expected duration of its run."""
        seconds = self.expected_duration(scene)
        if seconds is None:
            # A run by the fastest method, in compiled code, is assumed short until it is measured.
            is_fast = scene.method == _FASTEST_METHOD and not scene.over_time
            return Pace.AT_ONCE if is_fast else Pace.IDLE
        if seconds < MAX_IMMEDIATE_S:
            return Pace.AT_ONCE
        return Pace.IDLE if seconds < MAX_LIVE_S else Pace.OFF

    def show(self, run: LiveRun | None, displayed: Transient | None, error: str = "") -> None:
        """Show a run, or an error; the ghost is the previous curve, or else the displayed run."""
        if self.curve is not None:
            self.ghost = self.curve.result
        elif self.ghost is None:
            self.ghost = displayed
        self.curve, self.error, self.is_outdated = run, error, False
        self.status = "live: no result"
        if run is not None:
            self.status = f"live in {_short_duration(run.duration)}; Run keeps it"

    def clear(self, status: str = "") -> None:
        """Remove the live curve and its ghost."""
        self.curve = self.ghost = None
        self.status, self.error, self.is_outdated = status, "", False

    def announce_run(self, scene: Scene | None) -> None:
        """Set the status: a run follows when the edits pause, or when the inputs are valid."""
        self.is_outdated = True
        if scene is None:
            self.status = "live: waits for valid inputs"
            return
        seconds = self.expected_duration(scene)
        delay = " when idle" if seconds is None else f" in about {_short_duration(seconds)}"
        self.status = f"live: new curve{delay}"

    def switch_off(self, scene: Scene) -> None:
        """Remove the live curve, because a run would take too long, and say so in the status."""
        seconds = self.expected_duration(scene)
        duration = "" if seconds is None else f", a run takes {duration_text(seconds)}"
        self.clear(f"live off{duration}; Run computes it")


def _scene_kind(scene: Scene) -> Hashable:
    # What the computing time per simulated second depends on most.
    finite_belt = scene.parameters.v_belt is not None
    return scene.method, scene.separation, bool(scene.accuracy), finite_belt, bool(scene.over_time)


def _short_duration(seconds: float) -> str:
    return f"{1e3 * seconds:.2g} ms" if seconds < MAX_IMMEDIATE_S else f"{seconds:.2g} s"

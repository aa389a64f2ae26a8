"""Messages from widgets to the screen."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual.message import Message

from fivtui.scene import OverTime, Scene
from fivtui.transient import Transient
from fivtui.tui.session import DisplayedStudy, Job, LiveJob, Outcome, Run

if TYPE_CHECKING:
    from fivtui.orbits import Coexistence
    from fivtui.safety import SafeFriction


@dataclass
class FieldEdited(Message):
    """The user changed a field's text, by typing or (`typed` False) otherwise."""

    name: str
    text: str
    typed: bool = True


@dataclass
class FieldStepped(Message):
    """The user changed a number by a step up (+1) or down (-1)."""

    name: str
    direction: int
    fine: bool


@dataclass
class FieldFocused(Message):
    """A field got the focus."""

    name: str


@dataclass
class SearchUpdated(Message):
    """Result of an attractor search, perhaps outdated.

    The last one has the safe friction, or nothing if that could not be computed.
    """

    job: Job
    found: "Coexistence | None" = None
    error: str = ""
    done: bool = True
    safe: "SafeFriction | None" = None
    last: bool = False


@dataclass
class RunRequested(Message):
    """The user wants to start a run or stop the active one."""


@dataclass
class RunEnded(Message):
    """A run's thread ended, perhaps after the run was stopped."""

    run: Run
    outcome: Outcome[Transient]


@dataclass
class LiveRequested(Message):
    """A tab that shows the live curve is in sight, and the scene may have changed."""


@dataclass
class LiveEnded(Message):
    """The thread of a live run ended, perhaps after it was stopped; `seconds` is its duration."""

    job: LiveJob
    outcome: Outcome[Transient]
    seconds: float


@dataclass
class RunActionRequested(Message):
    """The user wants an action on a run: `what` is a name in `run_control.ACTS`."""

    number: int
    what: str


@dataclass
class RunsChanged(Message):
    """A run was started, stopped, finished or changed."""


@dataclass
class Reported(Message):
    """Something to log; unless it is `routine`, the user is notified at once."""

    words: str
    error: bool = False
    routine: bool = False


@dataclass
class ExportEnded(Message):
    """Posted after an export; `error` is set if it failed.

    For a browser the file is not kept, and `download` has its bytes.
    """

    what: str
    path: Path
    error: str
    download: bytes | None = None


@dataclass
class PointOpened(Message):
    """The user wants to run a point of a chart: its field texts, and where it is from."""

    texts: dict[str, str]
    words: str


@dataclass
class SceneLoaded(Message):
    """A scene is to be edited; `source` is its preset or file, `words` go to the log."""

    scene: Scene
    source: str
    words: str


@dataclass
class TablesChosen(Message):
    """Tables are to be what parameters follow over time; `words` go to the log."""

    over_time: OverTime
    words: str


@dataclass
class SceneSaved(Message):
    """The edited scene was written to a file."""

    scene: Scene
    path: Path


@dataclass
class RunRead(Message):
    """A transient was read from a file."""

    path: Path
    scene: Scene
    result: Transient


@dataclass
class StudyRead(Message):
    """A sweep, map or trade-off was read from a file; `kind` is the tab that shows it."""

    kind: str
    study: DisplayedStudy[Any]


@dataclass
class SessionRequested(Message):
    """The user wants to open another saved session, by its number."""

    number: int


@dataclass
class ResultsRestored(Message):
    """Results of the last session were read; `errors` says which could not be."""

    results: dict[str, Any]
    errors: list[str]

"""What widgets tell the screen."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual.message import Message

from fivtui.scene.scene import Scene
from fivtui.transient.result import Transient
from fivtui.tui.session.jobs import Job
from fivtui.tui.session.runs import Outcome, Run
from fivtui.tui.session.shown import Shown

if TYPE_CHECKING:
    from fivtui.orbits.attractor_search import Coexistence


@dataclass
class FieldEdited(Message):
    """The user gave a field another text: in its editor, unless it was not typed."""

    name: str
    text: str
    typed: bool = True


@dataclass
class FieldNudged(Message):
    """The user asked for a little more (+1) or less (-1) of a number."""

    name: str
    direction: int
    fine: bool


@dataclass
class FieldFocused(Message):
    """A field has the focus now."""

    name: str


@dataclass
class Searched(Message):
    """What a search for attractors found, perhaps of values that are no longer edited."""

    job: Job
    found: "Coexistence | None" = None
    error: str = ""
    done: bool = True


@dataclass
class RunAsked(Message):
    """The user asked to run, or to stop what runs."""


@dataclass
class RunEnded(Message):
    """The thread of a run came to its end, perhaps long after the run was stopped."""

    run: Run
    outcome: Outcome


@dataclass
class RunActed(Message):
    """The user wants something done with a run: `what` is a name in `run_desk.ACTS`."""

    number: int
    what: str


@dataclass
class RunsChanged(Message):
    """A run began, ended or was stopped."""


@dataclass
class Reported(Message):
    """Something to log, and unless it is routine to tell the user at once."""

    words: str
    error: bool = False
    routine: bool = False


@dataclass
class ExportEnded(Message):
    """A file was written, or not: then with an error."""

    what: str
    path: Path
    error: str


@dataclass
class PointOpened(Message):
    """The user wants to see a point's transient: texts of fields, and where they are from."""

    texts: dict[str, str]
    words: str


@dataclass
class SceneLoaded(Message):
    """A scene is to be edited; `source` is how the command line would name it, `words` says why."""

    scene: Scene
    source: str
    words: str


@dataclass
class SceneSaved(Message):
    """What is edited was written to a file."""

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
    shown: Shown[Any]


@dataclass
class SessionAsked(Message):
    """The user wants another session that is kept, by its number."""

    number: int


@dataclass
class ResultsRestored(Message):
    """Results of the last session were read, see `snapshot.take_back`, or not: then with errors."""

    results: dict[str, Any]
    errors: list[str]

"""Messages from widgets to the screen."""

from dataclasses import dataclass

from textual.message import Message

from fivtui.scene import Scene


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
class RunRequested(Message):
    """The user wants to start a run or stop the active one."""


@dataclass
class LiveRequested(Message):
    """A tab with the live curve is visible, and the scene may have changed."""


@dataclass
class RunActionRequested(Message):
    """The user wants an action on a run: `action` is a name in `RunActions`."""

    number: int
    action: str


@dataclass
class RunsChanged(Message):
    """A run was started, stopped, finished or changed."""


@dataclass
class Reported(Message):
    """A message for the log; unless it is `routine`, the user is notified."""

    text: str
    error: bool = False
    routine: bool = False


@dataclass
class PointOpened(Message):
    """The user wants to run a point of a chart: its field texts, and a log message."""

    texts: dict[str, str]
    report: str


@dataclass
class SceneLoaded(Message):
    """A scene was loaded to be edited; `source` is its preset or file, `report` is logged."""

    scene: Scene
    source: str
    report: str


@dataclass
class SessionRequested(Message):
    """The user wants to open another saved session, by its number."""

    number: int

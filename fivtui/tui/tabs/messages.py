"""Messages that widgets post to the screen.

The live curve is a run in the background that follows every edit.
"""

from dataclasses import dataclass

from textual.message import Message

from fivtui.scene import Scene


@dataclass
class FieldEdited(Message):
    """The user changed the text of a field in its editor."""

    name: str
    text: str


@dataclass
class FieldStepped(Message):
    """The user changed a number by a step up (+1) or down (-1); if `fine`, by a tenth of it."""

    name: str
    direction: int
    fine: bool


@dataclass
class FieldFocused(Message):
    """A field got the focus."""

    name: str


@dataclass
class TabKeyPressed(Message):
    """The user pressed a key that a field does not accept as text; it may be one of the tab."""

    key: str


class RunRequested(Message):
    """The user wants to start a run or stop the active one."""


class LiveRequested(Message):
    """The live curve must be updated: its tab is visible, and the scene may have changed."""


@dataclass
class RunActionRequested(Message):
    """The user wants an action on the run `number`.

    `action` is load, show, overlay, baseline, delete, colour or marker.
    """

    number: int
    action: str


class RunsChanged(Message):
    """A run was started, stopped, finished or changed."""


@dataclass
class Reported(Message):
    """A message for the log; if it is not `routine`, it is also displayed as a notice."""

    text: str
    error: bool = False
    routine: bool = False


@dataclass
class PointRunRequested(Message):
    """The user wants a run with the parameters at a point of a chart.

    `texts` are the texts of the fields to change, `report` is logged.
    """

    texts: dict[str, str]
    report: str


@dataclass
class SceneLoaded(Message):
    """A scene was loaded to be edited; `source` is its preset or file, `report` is logged."""

    scene: Scene
    source: str
    report: str

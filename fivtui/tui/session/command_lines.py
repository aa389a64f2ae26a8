"""Shell commands that compute what a tab shows. Imports no Textual."""

import dataclasses
import shlex
from typing import Any, Final

from fivtui.model import InputError
from fivtui.results import Command
from fivtui.scene import Scene
from fivtui.studies import command_of

from .scene_differences import base_scene, differences

# Error targets replace these.
_OF_ACCURACY: Final = ("tol", "step")


@dataclasses.dataclass(frozen=True, slots=True)
class Origin:
    """A scene with its name on the command line: preset or file, empty for the base scene."""

    scene: Scene
    source: str


def _words(scene: Scene, origin: Origin, command: Command) -> list[str]:
    # The command, its scene, and an option for every difference to that.
    words = ["fivtui", command.name, *([origin.source] if origin.source else [])]
    following = _OF_ACCURACY if scene.accuracy else ()
    for difference in differences(scene, origin.scene):
        if difference.name in command.said and difference.name not in following:
            words += difference.words
    return words


def _unsaid(scene: Scene, begin: Scene, command: Command) -> list[str]:
    # What no option changes in the scene that a command begins with, and must: most commands take
    # no tables over time, and none switches separation on again or removes error targets.
    needed = {"over_time": (), **command.needed}
    found = [name for name, value in needed.items() if getattr(begin, name) != value]
    if "separation" in command.said and scene.separation and not begin.separation:
        found.append("separation")
    if "accuracy" in command.said and not scene.accuracy and begin.accuracy:
        found.append("accuracy")
    return found


def study_line(kind: str, of: Any, origin: Origin) -> str:
    """The command that computes a study of a kind, quoted for a POSIX shell.

    `of` is its result, or what it is of, see `StudyKind.command`. Raises `InputError` if no command
    can say it.
    """
    command = command_of(kind, of)
    scene = dataclasses.replace(base_scene(), **command.scene)
    begin = origin
    if not origin.source or _unsaid(scene, origin.scene, command):
        begin = Origin(base_scene(), "")
        if unsaid := _unsaid(scene, begin.scene, command):
            names = " and ".join(unsaid)
            raise InputError(f"{kind}: no option sets {names}; save the scene to a file first")
    words = _words(scene, begin, command) if command.scene else ["fivtui", command.name]
    return shlex.join([*words, *command.words])

"""Shell commands that compute what a tab shows. Imports no Textual."""

import dataclasses
import shlex
from collections.abc import Collection
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


def _words(command: str, scene: Scene, origin: Origin, said: Collection[str]) -> list[str]:
    # The command, its scene, and an option for every difference to that.
    begin, words = origin.scene, ["fivtui", command, origin.source]
    considered = "separation" in said and scene.separation and not begin.separation
    by_tolerance = "accuracy" in said and not scene.accuracy and begin.accuracy
    if not origin.source or considered or by_tolerance:
        # No option switches separation on again, or removes error targets.
        begin, words = base_scene(), ["fivtui", command]
    following = _OF_ACCURACY if scene.accuracy else ()
    for difference in differences(scene, begin):
        if difference.name in said and difference.name not in following:
            words += difference.words
    return words


def _unfit(scene: Scene, command: Command) -> list[str]:
    # Fields of a scene that are not as the command needs them: most take no tables over time.
    needed = {"over_time": (), **command.needed}
    return [name for name, value in needed.items() if getattr(scene, name) != value]


def study_line(kind: str, of: Any, origin: Origin) -> str:
    """The command that computes a study of a kind, quoted for a POSIX shell.

    `of` is its result, or what it is of, see `StudyKind.command`. Raises `InputError` if no command
    can say it.
    """
    command = command_of(kind, of)
    scene = dataclasses.replace(base_scene(), **command.scene)
    begin = origin
    if not origin.source or _unfit(origin.scene, command):
        begin = Origin(base_scene(), "")
        if unfit := _unfit(begin.scene, command):
            said = " and ".join(unfit)
            raise InputError(f"{kind}: no option says its {said}; a scene file must")
    words = _words(command.name, scene, begin, command.said) if command.scene else []
    return shlex.join([*(words or ["fivtui", command.name]), *command.words])

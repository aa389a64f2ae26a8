"""Shell commands that compute the content of a tab. Imports no Textual."""

import dataclasses
import shlex
from typing import Any, Final

from fivtui.model import InputError
from fivtui.results import Command
from fivtui.scene import Scene
from fivtui.studies import command_of

from .scene_differences import default_scene, differences

# Settings that error targets replace.
_SET_BY_ACCURACY: Final = ("tol", "step")


@dataclasses.dataclass(frozen=True, slots=True)
class Origin:
    """A scene with its name on the command line: preset or file, empty for the base scene."""

    scene: Scene
    source: str


def _arguments(scene: Scene, origin: Origin, command: Command) -> list[str]:
    # The command, its scene, and an option for every difference from that scene.
    arguments = ["fivtui", command.name, *([origin.source] if origin.source else [])]
    ignored = _SET_BY_ACCURACY if scene.accuracy else ()
    for difference in differences(scene, origin.scene):
        if difference.name in command.settable and difference.name not in ignored:
            arguments += difference.arguments
    return arguments


def _unset_fields(scene: Scene, begin: Scene, command: Command) -> list[str]:
    # Fields that differ but cannot be set by an option: most commands take no tables over time,
    # and none switches separation on again or removes error targets.
    needed = {"over_time": (), **command.needed}
    fields = [name for name, value in needed.items() if getattr(begin, name) != value]
    if "separation" in command.settable and scene.separation and not begin.separation:
        fields.append("separation")
    if "accuracy" in command.settable and not scene.accuracy and begin.accuracy:
        fields.append("accuracy")
    return fields


def study_command(kind: str, of: Any, origin: Origin) -> str:
    """The command that computes a study of a kind, quoted for a POSIX shell.

    `of` is its result or its request, see `StudyKind.command`. Raises `InputError` if no command
    can express it.
    """
    command = command_of(kind, of)
    scene = dataclasses.replace(default_scene(), **command.scene)
    begin = origin
    if not origin.source or _unset_fields(scene, origin.scene, command):
        begin = Origin(default_scene(), "")
        if unset := _unset_fields(scene, begin.scene, command):
            names = " and ".join(unset)
            raise InputError(f"{kind}: no option sets {names}; save the scene to a file first")
    arguments = _arguments(scene, begin, command) if command.scene else ["fivtui", command.name]
    return shlex.join([*arguments, *command.arguments])

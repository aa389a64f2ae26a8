"""Shell commands that compute the content of a tab. Imports no Textual.

The base scene is that of a command without the name of a scene.
"""

import dataclasses
import shlex
from typing import Any

from fivtui.model import NONE_TEXT, InputError
from fivtui.results import Command
from fivtui.scene import Scene
from fivtui.studies import build_command
from fivtui.transient import SET_BY_ACCURACY, SETTINGS, uses_step

from .editing import Editing
from .scene_differences import base_scene, differences


def _fields_without_option(scene: Scene, base: Scene, command: Command) -> list[str]:
    # Fields in which `base` differs from `scene` and that no option sets. Most commands accept no
    # tables over time; for others, `scene_only` has those of the study. No option switches on
    # separation, so that the slider may leave the belt, or removes error targets.
    required_values = {"over_time": (), **command.scene_only}
    fields = [name for name, value in required_values.items() if getattr(base, name) != value]
    if command.scattered is not None and not {*dict(base.scatter)} <= {*command.scattered}:
        fields.append("scatter")
    if "separation" in command.settable and scene.separation and not base.separation:
        fields.append("separation")
    if "accuracy" in command.settable and not scene.accuracy and base.accuracy:
        fields.append("accuracy")
    return fields


def study_command(kind: str, study: Any, origin: Editing) -> str:
    """The command that computes a study of a kind, quoted for a POSIX shell.

    `study` is a result or a request, see `StudyKind.command`. The command names the preset or file
    that `origin` has loaded, with options for what differs from it. Raises `InputError` if no
    command computes the study.
    """
    command = build_command(kind, study)
    scene = dataclasses.replace(base_scene(), **command.scene)
    # Start from the origin if options can express the differences, else from the base scene.
    base, source = origin.loaded, origin.source
    if not source or _fields_without_option(scene, base, command):
        base, source = base_scene(), ""
        if names := _fields_without_option(scene, base, command):
            fields = " and ".join(names)
            raise InputError(f"{kind}: no option sets {fields}; save the scene to a file first")
    arguments = ["fivtui", command.name]
    if command.scene:
        arguments += [source] if source else []
        fixed_step = ("tol",) if uses_step(scene.method) else ()
        ignored = SET_BY_ACCURACY if scene.accuracy else fixed_step
        for name, text in differences(scene, base).items():
            # No option sets tables over time.
            if name in command.settable and name not in {*ignored, *dict(base.over_time)}:
                setting = SETTINGS.get(name)
                assignment = ["--set", f"{name}={text or NONE_TEXT}"]
                arguments += assignment if setting is None else setting.command_options(text)
    return shlex.join([*arguments, *command.arguments])

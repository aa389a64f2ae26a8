"""Kind of study: comparison of a run with a measurement."""

from typing import Any, Final

from fivtui.results import TABLE_SUFFIXES, Command, StudyKind, command_for, list_printer

from .options import ValidateOptions


def _command(scene_and_options: tuple[Any, ValidateOptions]) -> Command:
    # The argument has the scene and the options of the comparison.
    scene, options = scene_and_options
    needed = {"accuracy": scene.accuracy, "over_time": scene.over_time}
    return command_for("validate", scene, options, needed=needed)


VALIDATION: Final = StudyKind(
    data="validation",
    show=list_printer("Run beside measured data"),
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    header=frozenset({"validation"}),
    stem=lambda result: f"validation-{result.quantity}",
    command=_command,
)

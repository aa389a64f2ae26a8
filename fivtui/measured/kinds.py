"""Kind of study: comparison of a run with a measurement."""

from typing import Any, Final

from fivtui.results import TABLE_SUFFIXES, Command, StudyKind, command_for, list_printer

from .options import ValidateOptions


def _command(scene_and_options: tuple[Any, ValidateOptions]) -> Command:
    # The command line that repeats a comparison: the scene has the parameters and settings of the
    # run, the options have the measured file and the tolerances.
    scene, options = scene_and_options
    # No option sets these two: error targets, and tables of parameters that change with time.
    scene_only = {"accuracy": scene.accuracy, "over_time": scene.over_time}
    return command_for("validate", scene, options, scene_only=scene_only)


VALIDATION: Final = StudyKind(
    contents_name="validation",
    show=list_printer(title="Run beside measured data"),
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    # The key by which the header of a saved table is recognised.
    header_keys=frozenset({"validation"}),
    stem=lambda result: f"validation-{result.quantity}",
    command=_command,
)

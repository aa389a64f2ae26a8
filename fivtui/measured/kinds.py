"""Kind of study: comparison of a run with a measurement."""

from typing import Any, Final

from fivtui.results import TABLES, Command, StudyKind, command_for, listed

from .options import ValidateOptions


def _command(compared: tuple[Any, ValidateOptions]) -> Command:
    # The argument of `command`: a scene, and the options of the comparison.
    scene, options = compared
    needed = {"accuracy": scene.accuracy, "over_time": scene.over_time}
    return command_for("validate", scene, options, needed=needed)


VALIDATION: Final = StudyKind(
    data="validation",
    show=listed("Run beside measured data"),
    suffixes=TABLES,
    as_json=True,
    header=frozenset({"validation"}),
    stem=lambda result: f"validation-{result.quantity}",
    command=_command,
)

"""Comparisons of a run with a measurement among the studies."""

from typing import Any, Final

from fivtui.results import TABLES, Command, StudyKind, command_for, listed

from .options import ValidateOptions


def _command(compared: tuple[Any, ValidateOptions]) -> Command:
    # Of a scene and the options that say what it is compared with.
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

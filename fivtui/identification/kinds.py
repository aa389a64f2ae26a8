"""Kind of study: parameters fitted to measurements."""

from typing import Any, Final

from fivtui.lazy import lazy_modules
from fivtui.results import Command, StudyKind, command_for, list_printer

from .options import IdentifyOptions

(result,) = lazy_modules(__name__, "result")


def _command(scene_and_options: tuple[Any, IdentifyOptions]) -> Command:
    scene, options = scene_and_options
    return command_for("identify", scene, options)


IDENTIFICATION: Final = StudyKind(
    contents_name="fitted scene",
    show=list_printer("Parameters fitted to measurements"),
    suffixes=(".toml",),
    save=result.save_fitted_scene,
    as_json=True,
    stem=lambda result: f"fitted-{'-'.join(result.fit)}",
    command=_command,
)

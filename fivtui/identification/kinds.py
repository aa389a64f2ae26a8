"""Kind of study: parameters fitted to measurements."""

from typing import Any, Final

from fivtui.lazy import lazy_modules
from fivtui.results import Command, Storage, StudyKind, command_for, list_printer

from .options import IdentifyOptions

(result,) = lazy_modules(__name__, "result")
# Approximate bytes of a sample in JSON.
_BYTES_PER_SAMPLE: Final = 75


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
    storage=Storage(
        ".json",
        save=result.store_identification,
        load=result.restore_identification,
        size=lambda fit: _BYTES_PER_SAMPLE * fit.t.size,
    ),
)

"""Reads result files for display. Imports no Textual."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from fivtui import studies
from fivtui.model import InputError
from fivtui.scene import Scene
from fivtui.transient import Transient
from fivtui.tui.session import check_drawable

# What of a kind of study cannot be displayed raises `InputError`.
_CHECKS: Final[Mapping[str, Callable[[Any], None]]] = {
    "sweep": lambda result: check_drawable(result.study)
}


def load_study(kind: str, path: Path) -> Any:
    """Read a result of a study; raises `InputError` if it cannot be read or displayed."""
    result = studies.load_study(kind, path)
    if kind in _CHECKS:
        try:
            _CHECKS[kind](result)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    return result


def load_run(path: Path) -> tuple[Scene, Transient]:
    """Read a scene and transient from a trajectory file; `InputError` if it is none."""
    result: Transient = studies.load_study("run", path)
    try:
        scene = Scene(
            name=path.stem,
            description="",
            parameters=result.parameters,
            separation=result.separation,
            start=result.start,
            t_end=result.t_end,
            tol=result.tol,
            method=result.method,
            step=result.step,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return scene, result

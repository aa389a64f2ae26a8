"""What can be written to files, as data. Imports no Textual, and matplotlib only when needed."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fivtui.core.errors import ComputationError, InputError
from fivtui.files import check_output
from fivtui.scene import Scene, save_scene

from .runs import Run


@dataclass(frozen=True, slots=True)
class Export:
    """Something that can be written to a file.

    Attributes
    ----------
    what : str
        One word for menus and messages.
    suffix : str
        Suffix proposed.
    check : callable
        Takes the path and whether to overwrite; raises `InputError` before any work is done.
    write : callable
        Takes the run, the path and whether to overwrite.
    """

    what: str
    suffix: str
    check: Callable[[Path, bool], None]
    write: Callable[[Run, Path, bool], None]


def _check_figure(path: Path, force: bool) -> None:
    from fivtui.figures import check_figure_path

    check_figure_path(path, force=force)


def _write_figure(run: Run, path: Path, force: bool) -> None:
    from fivtui.figures import save_figure, transient_figure

    if run.result is not None:
        save_figure(transient_figure([run.result]), path, force=force)


def _check_data(path: Path, force: bool) -> None:
    from fivtui.formats import check_columns_path

    check_columns_path(path, "trajectory", force=force)


def _write_data(run: Run, path: Path, force: bool) -> None:
    from fivtui.results import save_trajectory

    if run.result is not None:
        save_trajectory(run.result, path, force=force)


EXPORTS: Final[Mapping[str, Export]] = {
    export.what: export
    for export in (
        Export("figure", ".svg", _check_figure, _write_figure),
        Export("data", ".csv", _check_data, _write_data),
    )
}


def proposal(run: Run, export: Export) -> str:
    """A file name to begin with.

    Parameters
    ----------
    run : Run
        The run.
    export : Export
        What of it.

    Returns
    -------
    str
        Name of the scene and number of the run, with the suffix proposed.
    """
    safe = "".join(c if c.isalnum() or c in "-_" else "-" for c in run.scene.name)
    return f"{safe}-{run.number}{export.suffix}"


def write_export(export: Export, run: Run, path: Path, *, force: bool) -> str:
    """Write a file.

    Parameters
    ----------
    export : Export
        What of the run.
    run : Run
        A run that is done.
    path : Path
        The file.
    force : bool
        Whether a file that exists may be replaced.

    Returns
    -------
    str
        What went wrong, one line; empty if nothing did.
    """
    try:
        export.write(run, path, force)
    except (InputError, ComputationError) as error:
        return str(error)
    return ""


def check_scene_path(path: Path, force: bool) -> None:
    """Check that a scene can be written to a file.

    Parameters
    ----------
    path : Path
        The file.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If it cannot.
    """
    if path.suffix.lower() != ".toml":
        raise InputError(f"{path}: the suffix of a scene file must be .toml")
    check_output(path, force=force)


def save_scene_as(scene: Scene, path: Path, *, force: bool) -> Scene:
    """Write a scene under the name of its file.

    Parameters
    ----------
    scene : Scene
        The scene.
    path : Path
        The file.
    force : bool
        Whether a file that exists may be replaced.

    Returns
    -------
    Scene
        The scene as it was written.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    named = dataclasses.replace(scene, name=path.stem)
    save_scene(named, path, force=force)
    return named

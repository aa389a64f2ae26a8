"""What can be written to files, as data. Imports no Textual, and matplotlib only when needed."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.io.files import check_output, check_suffix, save_json
from fivtui.io.formats import FORMATS
from fivtui.model.errors import ComputationError, InputError
from fivtui.scene.scene import Scene, save_scene
from fivtui.tui.session.runs import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fivtui.transient.result import Transient
    from fivtui.tui.chart.chart import Seen

FIGURE: Final = "figure"
DATA: Final = "data"
# What is written, and the key that writes it.
KINDS: Final[Mapping[str, str]] = {FIGURE: "F6", DATA: "F7"}
_NO_RUN: Final = "no run to write yet: F5 runs the scene"

Save = Callable[[Path, bool], None]


@dataclass(frozen=True, slots=True)
class Export:
    """Something that can be written to a file.

    Attributes
    ----------
    what : str
        One word for menus and messages.
    of : str
        Of which it is, a few words.
    proposal : str
        A file name to begin with.
    suffixes : tuple of str
        The formats that there are.
    check : callable
        Takes the path and whether to overwrite; raises `InputError` before any work is done.
    write : callable
        Takes the path and whether to overwrite.
    """

    what: str
    of: str
    proposal: str
    suffixes: tuple[str, ...]
    check: Save
    write: Save

    @property
    def hint(self) -> str:
        """What is allowed."""
        return f"The suffix says the format: {', '.join(self.suffixes)}."


def figure_export(of: str, stem: str, draw: "Callable[[], Figure]") -> Export:
    """A figure that can be written.

    Parameters
    ----------
    of : str
        Of which it is, a few words.
    stem : str
        File name to begin with, without suffix; what a file name had better not have is replaced.
    draw : callable
        Makes the figure.

    Returns
    -------
    Export
        As PNG, SVG or PDF.
    """

    def check(path: Path, force: bool) -> None:
        from fivtui.plotting import check_figure_path

        check_figure_path(path, force=force)

    def write(path: Path, force: bool) -> None:
        from fivtui.plotting import save_figure

        save_figure(draw(), path, force=force)

    return Export(FIGURE, of, f"{_safe(stem)}.svg", (".png", ".svg", ".pdf"), check, write)


def seen_export(
    of: str, stem: str, seen: "Seen", names: "Callable[[], Mapping[str, str]]" = dict
) -> Export:
    """The charts in sight as a figure: parameters as in `figure_export` and `seen_figure`."""

    def draw() -> "Figure":
        from .chart_figure import seen_figure

        return seen_figure(seen, names())

    return figure_export(of, stem, draw)


def as_seen(whole: Export, seen: "Seen | None") -> Export:
    """An export of a study; its figure as it is seen, where a chart is in sight."""
    if whole.what != FIGURE or seen is None:
        return whole
    return seen_export(whole.of, Path(whole.proposal).stem, seen)


def points_export(of: str, stem: str, seen: "Seen") -> Export:
    """The points of the charts in sight as data: parameters as in `figure_export`."""

    def save(path: Path, force: bool) -> None:
        from .chart_figure import save_seen

        save_seen(seen, path, force=force)

    return data_export(of, stem, "chart's data", dict.fromkeys(FORMATS, save))


def data_export(of: str, stem: str, kind: str, writers: Mapping[str, Save]) -> Export:
    """Data that can be written.

    Parameters
    ----------
    of, stem
        As in `figure_export`.
    kind : str
        What a file holds, named in messages, e.g. ``"map"``.
    writers : mapping of str to callable
        By suffix; the first one is proposed.

    Returns
    -------
    Export
        In the formats of the writers.
    """

    def check(path: Path, force: bool) -> None:
        suffix = check_suffix(path, kind, writers)
        if suffix in FORMATS:
            try:
                FORMATS[suffix].check_installed()
            except InputError as error:
                raise InputError(f"{path}: {error}") from None
        check_output(path, force=force)

    def write(path: Path, force: bool) -> None:
        writers[check_suffix(path, kind, writers)](path, force)

    suffixes = tuple(writers)
    return Export(DATA, of, f"{_safe(stem)}{suffixes[0]}", suffixes, check, write)


def json_writer(data: Callable[[], Any]) -> Save:
    """A writer of JSON; `data` makes what JSON can hold."""

    def write(path: Path, force: bool) -> None:
        save_json(data(), path, force=force)

    return write


def _safe(stem: str) -> str:
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)


def run_export(what: str, run: Run | None) -> Export:
    """What can be written of a run.

    Parameters
    ----------
    what : str
        A name in `KINDS`.
    run : Run or None
        The run that is shown.

    Returns
    -------
    Export
        Its figure, or its trajectory.

    Raises
    ------
    InputError
        If there is no result.
    """
    if run is None or run.result is None:
        raise InputError(_NO_RUN)
    result, of, stem = run.result, f"run {run.number}", f"{run.scene.name}-{run.number}"
    if what == FIGURE:
        return figure_export(of, stem, lambda: _run_figure(result))

    def write(path: Path, force: bool) -> None:
        from fivtui.transient.files import save_trajectory

        save_trajectory(result, path, force=force)

    return data_export(of, stem, "trajectory", dict.fromkeys(FORMATS, write))


def _run_figure(result: "Transient") -> "Figure":
    from fivtui.transient.figure import transient_figure

    return transient_figure([result])


def write_export(export: Export, path: Path, *, force: bool) -> str:
    """Write a file.

    Parameters
    ----------
    export : Export
        What to write.
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
        export.write(path, force)
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

"""Exports of figures and data. Imports no Textual, and matplotlib only to draw a figure."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.charts import Heading
from fivtui.io import FORMATS, check_output, check_suffix, table_format
from fivtui.model import ComputationError, InputError
from fivtui.scene import Scene, save_scene
from fivtui.studies import save_study, study
from fivtui.tui.session import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fivtui.charts import VisibleCharts

FIGURE: Final = "figure"
DATA: Final = "data"
# Kinds of exports, which are identifiers of keys, too.
EXPORT_KINDS: Final = (FIGURE, DATA)
_NO_RUN: Final = "no run to export yet: press Run"

PathFunction = Callable[[Path], None]


@dataclass(frozen=True, slots=True)
class Export:
    """What can be written to a file: a figure or data.

    Attributes
    ----------
    kind : str
        One of `EXPORT_KINDS`.
    subject : str
        What is exported, in messages.
    file_name : str
        The suggested file name.
    suffixes : tuple of str
        Suffixes of the supported formats.
    check : callable
        Raises `InputError` if a path cannot be written.
    write : callable
        Writes the file.
    """

    kind: str
    subject: str
    file_name: str
    suffixes: tuple[str, ...]
    check: PathFunction
    write: PathFunction

    @property
    def hint(self) -> str:
        """The supported formats as text."""
        return f"The suffix selects the format: {', '.join(self.suffixes)}."


def figure_export(subject: str, stem: str, draw: "Callable[[], Figure]") -> Export:
    """A figure as PNG, SVG or PDF; `draw` creates it, `stem` is the suggested file name."""

    def check(path: Path) -> None:
        from fivtui.charts import check_figure_path

        check_figure_path(path)

    def write(path: Path) -> None:
        from fivtui.charts import save_figure

        save_figure(draw(), path)

    return Export(FIGURE, subject, f"{_clean(stem)}.svg", (".png", ".svg", ".pdf"), check, write)


def charts_export(
    subject: str, stem: str, charts: "VisibleCharts", heading: Heading | None = None
) -> Export:
    """The displayed charts as a figure; arguments as in `figure_export` and `charts_figure`."""

    def draw() -> "Figure":
        from fivtui.charts import charts_figure

        return charts_figure(charts, heading)

    return figure_export(subject, stem, draw)


def belt_export(
    export_kind: str,
    run: Run,
    charts: "VisibleCharts | None",
    window: tuple[float, float] | None,
    speed: float,
) -> Export:
    """The slider on the belt as a film or a picture; as data, the sound or the trajectory.

    `window` is the start and end of film and sound, s; `speed` is the speed of the film.
    """
    from fivtui.film import animate, check_film_path
    from fivtui.signals import sound

    result, export = run.result, run_export(export_kind, run)
    assert result is not None  # noqa: S101, checked by run_export
    stem, subject = Path(export.file_name).stem, f"run {run.number}, belt"
    if export_kind != FIGURE:

        def write_sound(path: Path) -> None:
            sound(result, path, window=window)

        writers = {".wav": write_sound, **dict.fromkeys(export.suffixes, export.write)}
        return data_export(subject, stem, "sound or trajectory", writers)
    heading = Heading([result.parameters], ignores_separation=not result.separation)
    picture = charts_export(subject, stem, charts, heading) if charts is not None else export

    def check(path: Path) -> None:
        if path.suffix.lower() in picture.suffixes:
            picture.check(path)
        else:
            check_film_path(path)

    def write(path: Path) -> None:
        if path.suffix.lower() in picture.suffixes:
            picture.write(path)
        else:
            animate(result, path, window=window, speed=speed)

    suffixes = (".gif", ".mp4", *picture.suffixes)
    return Export(FIGURE, subject, f"{stem}.gif", suffixes, check, write)


def with_displayed_charts(
    export: Export, charts: "VisibleCharts | None", heading: Heading | None = None
) -> Export:
    """The export; if it is a figure, that of the displayed charts, if there are any."""
    if export.kind != FIGURE or charts is None:
        return export
    return charts_export(export.subject, Path(export.file_name).stem, charts, heading)


def points_export(subject: str, stem: str, charts: "VisibleCharts") -> Export:
    """The points of the displayed charts as data."""

    def save(path: Path) -> None:
        from fivtui.charts import save_charts

        save_charts(charts, path)

    return data_export(subject, stem, "chart's data", dict.fromkeys(FORMATS, save))


def data_export(
    subject: str, stem: str, contents_name: str, writers: Mapping[str, PathFunction]
) -> Export:
    """Data in the formats of `writers`, by suffix; messages call them `contents_name`."""

    def check(path: Path) -> None:
        suffix = check_suffix(path, contents_name, writers)
        if suffix in FORMATS:
            # Raises `InputError` if the package for the format is missing.
            table_format(path, contents_name)
        check_output(path)

    def write(path: Path) -> None:
        writers[check_suffix(path, contents_name, writers)](path)

    suffixes = tuple(writers)
    return Export(DATA, subject, f"{_clean(stem)}{suffixes[0]}", suffixes, check, write)


def _clean(stem: str) -> str:
    # Replace characters that are unusual in file names.
    return "".join(sign if sign.isalnum() or sign in "-_" else "-" for sign in stem)


def run_export(export_kind: str, run: Run | None) -> Export:
    """A run's figure or trajectory; raises `InputError` if there is no result."""
    if run is None or run.result is None:
        raise InputError(_NO_RUN)
    stem = f"{run.scene.name}-{run.number}"
    return study_export(export_kind, "run", run.result, stem, subject=f"run {run.number}")


def study_export(export_kind: str, kind: str, result: Any, stem: str, subject: str = "") -> Export:
    """The figure or the data of the result of a study.

    `export_kind` is one of `EXPORT_KINDS`, `kind` the kind of study, `stem` the file name.
    """
    study_kind, subject = study(kind), subject or f"the {kind}"
    if export_kind == FIGURE:
        return figure_export(subject, stem, lambda: study_kind.figure(result))

    def write(path: Path) -> None:
        save_study(kind, result, path)

    suffixes = (*study_kind.suffixes, *([".json"] if study_kind.as_json else []))
    return data_export(subject, stem, study_kind.contents_name, dict.fromkeys(suffixes, write))


def scene_study_export(export_kind: str, kind: str, result: Any, name: str) -> Export:
    """The figure or the data of a study of the scene `name`."""
    return study_export(export_kind, kind, result, f"{name}-{study(kind).stem(result)}")


def write_export(export: Export, path: Path) -> str:
    """Write a file. Returns an error message, empty on success."""
    try:
        export.write(path)
    except (InputError, ComputationError) as error:
        return str(error)
    return ""


def check_scene_path(path: Path) -> None:
    """Raise `InputError` if a scene cannot be written to a path."""
    if path.suffix.lower() != ".toml":
        raise InputError(f"{path}: the suffix of a scene file must be .toml")
    check_output(path)


def save_scene_as(scene: Scene, path: Path) -> Scene:
    """Save a scene under the name of its file. Returns the renamed scene."""
    renamed_scene = dataclasses.replace(scene, name=path.stem)
    save_scene(renamed_scene, path)
    return renamed_scene

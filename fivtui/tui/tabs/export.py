"""Exports of figures and data to files, and of figures to the clipboard of the desktop.

Imports no Textual, and matplotlib only to draw a figure.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.charts import Heading, VisibleCharts
from fivtui.io import FORMATS, check_output, check_suffix, table_format, temporary_folder
from fivtui.model import InputError
from fivtui.studies import save_study, study
from fivtui.transient import Transient
from fivtui.tui.session import LiveRun, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURE: Final = "figure"
DATA: Final = "data"
# Kinds of exports, which are identifiers of keys, too.
EXPORT_KINDS: Final = (FIGURE, DATA)
_NO_RUN: Final = "no run to export yet: press Run"
_FIGURE_SUFFIXES: Final = (".svg", ".png", ".pdf")
_FILM_SUFFIXES: Final = (".gif", ".mp4")
# Time limit of the program that copies a picture, s.
_TIMEOUT_S: Final = 20.0
_NO_PROGRAM: Final = (
    "a picture cannot be copied without a desktop and wl-copy (Wayland) or xclip (X11); "
    "the plot can be copied as text"
)

PathFunction = Callable[[Path], object]


@dataclass(frozen=True, slots=True)
class Export:
    """What can be written to a file: a figure or data."""

    # One of `EXPORT_KINDS`.
    kind: str
    # This export in reports, such as "run 2, belt".
    subject: str
    # The suggested file name without suffix; may contain any characters.
    stem: str
    # By suffix, writes a file of this format; the first suffix is suggested.
    writers: Mapping[str, PathFunction]
    # What such files contain, in errors about the suffix, such as "film or picture".
    contents_name: str = "figure"

    @property
    def file_name(self) -> str:
        """The suggested file name, without characters that are unusual in file names."""
        stem = "".join(sign if sign.isalnum() or sign in "-_" else "-" for sign in self.stem)
        return f"{stem}{next(iter(self.writers))}"

    @property
    def hint(self) -> str:
        """The supported formats as text."""
        return f"The suffix selects the format: {', '.join(self.writers)}."

    def check(self, path: Path) -> None:
        """Raise `InputError` if a path cannot be written."""
        suffix = check_suffix(path, self.contents_name, self.writers)
        if suffix in FORMATS:
            # Raises `InputError` if the package for the format is missing.
            table_format(path, self.contents_name)
        if suffix in _FILM_SUFFIXES:
            from fivtui.film import check_film_path

            check_film_path(path)
        check_output(path)

    def write(self, path: Path) -> None:
        """Write the file."""
        self.writers[check_suffix(path, self.contents_name, self.writers)](path)


def _figure_export(subject: str, stem: str, draw: "Callable[[], Figure]") -> Export:
    def write(path: Path) -> None:
        from fivtui.charts import save_figure

        save_figure(draw(), path)

    return Export(FIGURE, subject, stem, dict.fromkeys(_FIGURE_SUFFIXES, write))


def charts_export(
    export_kind: str,
    subject: str,
    stem: str,
    charts: VisibleCharts,
    heading: Heading | None = None,
) -> Export:
    """The displayed charts as figure, their points as data; `stem` is the suggested file name."""

    def draw() -> "Figure":
        from fivtui.charts import charts_figure

        return charts_figure(charts, heading)

    def save(path: Path) -> None:
        from fivtui.charts import save_charts

        save_charts(charts, path)

    if export_kind == FIGURE:
        return _figure_export(subject, stem, draw)
    return Export(DATA, subject, stem, dict.fromkeys(FORMATS, save), "chart's data")


def study_export(
    export_kind: str,
    kind: str,
    result: Any,
    stem: str,
    subject: str = "",
    *,
    charts: VisibleCharts | None = None,
    heading: Heading | None = None,
) -> Export:
    """The figure or the data of the result of a study.

    `export_kind` is one of `EXPORT_KINDS`, `kind` the kind of study, `stem` the file name. The
    figure is that of the displayed `charts`, if there are any.
    """
    study_kind, subject = study(kind), subject or f"the {kind}"
    if export_kind == DATA:
        suffixes = (*study_kind.suffixes, *([".json"] if study_kind.as_json else []))
        writers = dict.fromkeys(suffixes, partial(save_study, kind, result))
        return Export(DATA, subject, stem, writers, study_kind.contents_name)
    if charts is not None:
        return charts_export(FIGURE, subject, stem, charts, heading)
    return _figure_export(subject, stem, lambda: study_kind.figure(result))


def run_export(export_kind: str, run: Run | LiveRun | None) -> Export:
    """The figure or trajectory of a run or live curve; raises `InputError` without a result."""
    if run is None or run.result is None:
        raise InputError(_NO_RUN)
    subject, number = "the live curve", run.name
    if isinstance(run, Run):
        subject, number = run.name, str(run.number)
    return study_export(export_kind, "run", run.result, f"{run.scene.name}-{number}", subject)


def belt_export(
    export: Export, result: Transient, window: tuple[float, float] | None, speed: float
) -> Export:
    """An export of a run or its picture, also as a film of the slider on the belt or as sound.

    `window` is the start and end of film and sound, s; `speed` is the speed of the film.
    """
    from fivtui.film import animate
    from fivtui.signals import sound

    if export.kind == FIGURE:
        film = partial(animate, result, window=window, speed=speed)
        writers: Mapping[str, PathFunction] = dict.fromkeys(_FILM_SUFFIXES, film)
        contents_name = "film or picture"
    else:
        writers, contents_name = {".wav": partial(sound, result, window=window)}, "sound or data"
    return replace(export, writers={**writers, **export.writers}, contents_name=contents_name)


def check_scene_path(path: Path) -> None:
    """Raise `InputError` if a scene cannot be written to a path."""
    check_suffix(path, "scene", (".toml",))
    check_output(path)


def copy_picture(export: Export) -> None:
    """Copy a figure to the clipboard as PNG; raises `InputError` if no program can do this."""
    with temporary_folder() as folder:
        path = folder / "picture.png"
        command = clipboard_command(path, sys.platform, os.environ)
        export.write(path)
        try:
            # Do not wait for output: the program provides the picture while in the background.
            none = subprocess.DEVNULL
            subprocess.run(  # noqa: S603, a program of the desktop
                command, stdin=none, stdout=none, stderr=none, timeout=_TIMEOUT_S, check=True
            )
        except subprocess.CalledProcessError:
            raise InputError(f"the picture is not copied: {command[0]} failed") from None
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InputError(f"the picture is not copied: {error}") from None


def clipboard_command(path: Path, platform: str, environment: Mapping[str, str]) -> Sequence[str]:
    """The command that copies a PNG file on a platform; raises `InputError` without a program."""
    if platform == "darwin":
        script = f'set the clipboard to (read POSIX file "{path}" as «class PNGf»)'
        return ["osascript", "-e", script]
    if platform == "win32":
        load_assemblies = "Add-Type -AssemblyName System.Windows.Forms, System.Drawing"
        image = f"[System.Drawing.Image]::FromFile('{path}')"
        script = f"{load_assemblies}; [System.Windows.Forms.Clipboard]::SetImage({image})"
        return ["powershell", "-NoProfile", "-STA", "-Command", script]
    if environment.get("WAYLAND_DISPLAY") and shutil.which("wl-copy"):
        return ["sh", "-c", 'exec wl-copy --type image/png < "$0"', str(path)]
    if environment.get("DISPLAY") and shutil.which("xclip"):
        return ["xclip", "-selection", "clipboard", "-target", "image/png", "-in", str(path)]
    raise InputError(_NO_PROGRAM)

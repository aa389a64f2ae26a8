"""Actions that open and save files: in dialogs for their paths, and in threads."""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, Final, cast

from fivtui.io import check_distinct, describe_files, output_path, temporary_folder
from fivtui.model import ComputationError, InputError
from fivtui.scene import Scene, load_scene, read_over_time, save_scene, scene_file
from fivtui.studies import check_readable, kind_of, load_study
from fivtui.transient import SETTINGS, Transient
from fivtui.tui.session import FILE_WRITES, SAFETY_MAPS, DisplayedStudy, check_drawable, study_key
from fivtui.tui.tabs import (
    Export,
    Pane,
    SceneLoaded,
    StudyPane,
    ViewsPane,
    check_scene_path,
    copy_picture,
)

from .dialogs import PathDialog
from .edit_actions import EditActions
from .run_actions import RunActions

_RESULT_HINT: Final = (
    "A file written by fivtui: run, sweep or map (.csv, .npz, .parquet), map, trade-off or "
    "branch (.json), trade-off (.csv), unfinished sweep (FILE.parts)."
)
_TABLE_HINT: Final = (
    "A CSV file with columns time and F, mu or v_belt (linear between rows), stiffnesses or "
    "dampings (held until the next row), in SI units."
)


class FileActions(EditActions, RunActions):
    """Actions on files of scenes, results, figures and data, and copies."""

    def _ask_path(self, dialog: PathDialog, use_path: Callable[[Path], None]) -> None:
        # Call `use_path` with the chosen path, unless the dialog is cancelled.
        self.app.push_screen(dialog, lambda path: None if path is None else use_path(path))

    def action_export(self, kind: str) -> None:
        """Export the figure or the data of the current tab."""

        def export(pane: Pane) -> None:
            with self.report_errors():
                self._export(pane.export(kind))

        self.tab_book.when_ready(export)

    def _export(self, export: Export) -> None:
        # Ask for a path and write an export to it, or to a file that the browser downloads.
        scene_path, is_web = scene_file(self.session.source), self.app.is_web
        # The browser chooses the folder; a download overwrites no file.
        written_file = _download_file if is_web else nullcontext
        hint = f"{export.hint} The browser downloads the file." if is_web else export.hint
        title, verb = (
            f"Export the {export.kind} of {export.subject}",
            "Download" if is_web else "Save",
        )

        def check(path: Path) -> None:
            with written_file(path) as file:
                # The export must not overwrite the opened scene.
                read_files = [] if scene_path is None else [("the scene opened", scene_path)]
                check_distinct([("the file", file)], read_files)
                export.check(file)

        def write(path: Path) -> None:
            # The program waits for this file before it exits.
            with self.report_errors(), FILE_WRITES.track(str(path)), written_file(path) as file:
                export.write(file)
                report = f"{export.kind} written to {describe_files(file)}"
                if is_web:
                    data = BytesIO(file.read_bytes())
                    self.call_later(self.app.deliver_binary, data, save_filename=file.name)
                    report = f"{export.kind} {file.name}: in the downloads folder of the browser"
                self.report(report)

        dialog = PathDialog(title, export.file_name, hint, check, verb)
        self._ask_path(dialog, lambda path: self.run_in_thread(export.kind, lambda: write(path)))

    def copy_command(self, pane: Pane) -> None:
        """Copy the command that computes the content of a tab."""
        with self.report_errors():
            line = pane.command_line()
            self._copy(line, f"copied: {line}")

    def copy_plot(self, pane: Pane) -> None:
        """Copy the plots of a tab as text."""
        views = cast("ViewsPane", pane).shown_chart_views()
        self._copy("\n".join(view.text() for view in views), "the plot is copied as text")

    def _copy(self, text: str, report: str) -> None:
        self.app.copy_to_clipboard(text)
        self.report(report)

    def copy_picture(self, pane: Pane) -> None:
        """Copy the figure of a tab as a picture."""

        def copy_figure() -> None:
            with self.report_errors():
                copy_picture(export)
                self.report(f"the figure of {export.subject} is copied")

        with self.report_errors():
            export = pane.export("figure")
            self.run_in_thread("copying", copy_figure)

    def action_open_scene(self) -> None:
        """Ask for a scene or result file and open it."""

        def load(path: Path) -> None:
            if _is_scene(path):
                self.open_path(path)
            else:
                self._read_result(path)

        def check(path: Path) -> None:
            if _is_scene(path):
                load_scene(path)
            else:
                check_readable(path)

        hint = "A scene (.toml) or a result file written by fivtui."
        if self.session.recent:
            hint += " The palette (Ctrl+P) lists recent scenes."
        self._ask_path(PathDialog("Open a scene or a result", "", hint, check, verb="Open"), load)

    def open_path(self, path: Path) -> None:
        """Load a scene file."""
        with self.report_errors():
            scene = load_scene(path)
            report = f"scene {scene.name} opened: {path}"
            self.post_message(SceneLoaded(scene, str(path), report))

    def action_save_scene(self, ask: bool = False) -> None:
        """Save the edited scene to its file.

        Asks for a path if `ask`, if the scene has no .toml file, or if it was changed elsewhere.
        """
        with self.report_errors():
            scene, file = self.session.scene(), scene_file(self.session.source)
            if file is not None and not _is_scene(file):
                # A scene can be read from any file, but is written to a .toml file only.
                file = None
            if file is not None and not ask and self._is_current(file):
                self._save(scene, output_path(file, force=True))
                return
            proposal = f"{scene.name}.toml" if file is None else str(file)
            hint = "A scene file (.toml)."
            dialog = PathDialog("Save the scene as", proposal, hint, check_scene_path)
            self._ask_path(dialog, lambda path: self._save(scene, path))

    def _is_current(self, file: Path) -> bool:
        try:
            return load_scene(file) == self.session.loaded
        except InputError:
            return False

    def _save(self, scene: Scene, path: Path) -> None:
        with self.report_errors():
            # A scene has the name of its file.
            saved_scene = replace(scene, name=path.stem)
            save_scene(saved_scene, path)
            self.session.record_saved(saved_scene, str(path))
            self.session.add_recent(str(path))
            self.show_edit(f"scene {saved_scene.name} saved: {describe_files(path)}")

    def action_read_tables(self) -> None:
        """Ask for a file with parameters over time, and add them to the scene."""

        def read(path: Path) -> None:
            with self.report_errors():
                # Raises `InputError` if the tables do not fit the parameters of the scene.
                scene = replace(self.session.scene(), over_time=read_over_time(path))
                self.session.set_tables(scene.over_time)
                self.show_edit(f"tables over time from {path}")

        dialog = PathDialog("Parameters over time", "", _TABLE_HINT, read_over_time, verb="Read")
        self._ask_path(dialog, read)

    def action_read_result(self) -> None:
        """Ask for a result file and read it."""
        dialog = PathDialog("Read a result", "", _RESULT_HINT, check_readable, verb="Read")
        self._ask_path(dialog, self._read_result)

    def _read_result(self, path: Path) -> None:
        def read_file() -> None:
            with self.report_errors():
                kind = kind_of(path)
                if kind == "run":
                    self.call_later(self.add_run, path, *load_run(path))
                else:
                    study = DisplayedStudy(load_displayable(kind, path), path.stem, str(path))
                    self.call_later(self.show_study, kind, study)

        self.run_in_thread("reading", read_file)

    def show_study(self, kind: str, study: DisplayedStudy[Any]) -> None:
        """Display a result in the tab of its kind."""
        key = study_key(kind, study.value)
        self.session.studies[key] = study

        def show(pane: Pane) -> None:
            if isinstance(pane, StudyPane):
                if key in pane.VIEWS:
                    pane.show_view(key)
                pane.stop()
                pane.reset_charts()

        self.action_show_tab("safe-mu" if key in SAFETY_MAPS else kind)
        self.tab_book.when_ready(show)
        self.tab_book.update_pane_from_session()
        self.report(f"{kind} read from {study.source}")


def load_displayable(kind: str, path: Path) -> Any:
    """Read a result of this kind.

    Raises `InputError` if it cannot be read, or is a sweep over too many parameters to draw.
    """
    result = load_study(kind, path)
    if kind == "sweep":
        with _errors_with_path(path):
            check_drawable(result.study)
    return result


def load_run(path: Path) -> tuple[Scene, Transient]:
    """Read scene and transient from a trajectory file; raises `InputError` if it is invalid."""
    run: Transient = load_study("run", path)
    settings: dict[str, Any] = {name: getattr(run, name) for name in SETTINGS if hasattr(run, name)}
    with _errors_with_path(path):
        scene = Scene(name=path.stem, description="", parameters=run.parameters, **settings)
    return scene, run


@contextmanager
def _errors_with_path(path: Path) -> Iterator[None]:
    # Prefix errors with the path.
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@contextmanager
def _download_file(path: Path) -> Iterator[Path]:
    # A temporary file whose name browsers accept: ASCII letters, digits, and ``-_.``. Errors do not
    # name its folder.
    with temporary_folder() as folder:
        try:
            yield folder / re.sub(r"[^a-zA-Z0-9_.-]", "-", path.name)
        except (InputError, ComputationError) as error:
            raise InputError(str(error).replace(f"{folder}{os.sep}", "")) from None


def _is_scene(path: Path) -> bool:
    return path.suffix.lower() == ".toml"

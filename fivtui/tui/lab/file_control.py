"""Opens and saves files: dialogs on the screen, work in threads."""

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from textual.message import Message
from textual.screen import Screen

from fivtui.io import check_apart
from fivtui.model import ComputationError, InputError
from fivtui.scene import Scene, load_scene, read_over_time, scene_file
from fivtui.studies import check_readable, kind_of
from fivtui.tui.persistence import load_run, load_study
from fivtui.tui.session import WRITING, DisplayedStudy, Session
from fivtui.tui.tabs import (
    Export,
    ExportEnded,
    Pane,
    Reported,
    RunRead,
    SceneLoaded,
    SceneSaved,
    StudyRead,
    TablesChosen,
    ViewsPane,
    check_scene_path,
    copy_picture,
    save_scene_as,
    write_export,
)

from .dialogs import ChosenFile, PathDialog

_READABLE: Final = (
    "A file written by fivtui: run, sweep or map (.csv, .npz, .parquet), map, trade-off or "
    "branch (.json), trade-off (.csv), unfinished sweep (FILE.parts)."
)


_TABLES: Final = (
    "A CSV file with columns time and F, mu or v_belt, in SI units; linear between its rows."
)


class FileController:
    """Reads and writes files for a screen, which shows the dialogs and receives the messages."""

    def __init__(self, screen: Screen[None], session: Session) -> None:
        self._screen = screen
        self._session = session

    def export(self, export: Export) -> None:
        """Ask for a path and write an export there."""
        if self._screen.app.is_web:
            self._ask_for_download(export)
            return

        def write(target: ChosenFile | None) -> None:
            if target is not None:
                self._write(export, target)

        opened = scene_file(self._session.source)

        def check(path: Path, force: bool) -> None:
            # Checked before the question whether to overwrite.
            read = [] if opened is None else [("the scene opened", opened)]
            check_apart([("the file", path)], read)
            export.check(path, force)

        dialog = PathDialog(_title(export), export.proposal, export.hint, check)
        self._screen.app.push_screen(dialog, write)

    def _ask_for_download(self, export: Export) -> None:
        # The browser knows folders of its own: a name is asked for, and no file here overwritten.
        def download(target: ChosenFile | None) -> None:
            if target is not None:
                self._download(export, download_name(target.path))

        def check(path: Path, _force: bool) -> None:
            name = download_name(path)
            with TemporaryDirectory() as folder:
                try:
                    export.check(Path(folder) / name, False)
                except InputError as error:
                    raise InputError(_without_folder(str(error), folder)) from None

        hint = f"{export.hint} The browser downloads the file."
        dialog = PathDialog(_title(export), export.proposal, hint, check, verb="Download")
        self._screen.app.push_screen(dialog, download)

    def _download(self, export: Export, name: str) -> None:
        def work() -> None:
            with TemporaryDirectory() as folder:
                path = Path(folder) / name
                error = _without_folder(write_export(export, path, force=False), folder)
                data = None if error else path.read_bytes()
            self._screen.post_message(ExportEnded(export.what, Path(name), error, data))

        self._screen.run_worker(work, name=export.what, thread=True, exit_on_error=False)

    def copy_command(self, pane: Pane) -> None:
        """Copy the command that computes what a tab shows."""
        try:
            line = pane.command_line()
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
        else:
            self._copy(line, f"copied: {line}")

    def copy_plot(self, pane: Pane) -> None:
        """Copy the plots of a tab as text."""
        plots = (
            [chart.text() for chart in pane.shown_views()] if isinstance(pane, ViewsPane) else []
        )
        if plots:
            self._copy("\n".join(plots), "the plot is copied as text")
        else:
            self._screen.post_message(Reported("there is no plot to copy", error=True))

    def _copy(self, text: str, words: str) -> None:
        self._screen.app.copy_to_clipboard(text)
        self._screen.post_message(Reported(words))

    def copy_picture(self, pane: Pane) -> None:
        """Copy the figure of a tab as a picture."""

        def work() -> None:
            try:
                copy_picture(export)
            except (InputError, ComputationError) as error:
                self._screen.post_message(Reported(str(error), error=True))
            else:
                self._screen.post_message(Reported(f"the figure of {export.of} is copied"))

        try:
            export = pane.export("figure")
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
        else:
            self._screen.run_worker(work, name="copying", thread=True, exit_on_error=False)

    def _write(self, export: Export, target: ChosenFile) -> None:
        def work() -> None:
            with WRITING.of(str(target.path)):
                error = write_export(export, target.path, force=target.force)
            self._screen.post_message(ExportEnded(export.what, target.path, error))

        self._screen.run_worker(work, name=export.what, thread=True, exit_on_error=False)

    def open_scene(self) -> None:
        """Ask for a scene or result file and open it."""

        def load(target: ChosenFile | None) -> None:
            if target is not None and _is_scene(target.path):
                self.open_path(target.path)
            elif target is not None:
                self._read(target.path)

        def check(path: Path, _force: bool) -> None:
            if _is_scene(path):
                load_scene(path)
            else:
                check_readable(path)

        hint = "A scene (.toml) or a result file written by fivtui."
        if self._session.recent:
            hint += " The palette (Ctrl+P) lists recent scenes."
        dialog = PathDialog("Open a scene or a result", "", hint, check, verb="Open")
        self._screen.app.push_screen(dialog, load)

    def open_path(self, path: Path) -> None:
        """Load a scene file."""
        try:
            scene = load_scene(path)
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
        else:
            words = f"scene {scene.name} opened: {path}"
            self._screen.post_message(SceneLoaded(scene, str(path), words))

    def save_scene(self, *, ask: bool) -> None:
        """Save the edited scene to its file.

        Asks for a path if `ask`, if the scene has no file, or if the file was changed elsewhere.
        """
        try:
            scene = self._session.scene()
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
            return
        own = self._own_file()
        if own is not None and not ask and self._unchanged(own):
            self._save(scene, ChosenFile(own, force=True))
            return

        def save(target: ChosenFile | None) -> None:
            if target is not None:
                self._save(scene, target)

        proposal = str(own) if own is not None else f"{scene.name}.toml"
        dialog = PathDialog(
            "Save the scene as", proposal, "A scene file (.toml).", check_scene_path
        )
        self._screen.app.push_screen(dialog, save)

    def _own_file(self) -> Path | None:
        path = Path(self._session.source)
        return path if path.suffix.lower() == ".toml" else None

    def _unchanged(self, path: Path) -> bool:
        try:
            return load_scene(path) == self._session.loaded
        except InputError:
            return False

    def _save(self, scene: Scene, target: ChosenFile) -> None:
        try:
            named = save_scene_as(scene, target.path, force=target.force)
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
        else:
            self._screen.post_message(SceneSaved(named, target.path))

    def read_tables(self) -> None:
        """Ask for a file with parameters over time, and give them to the scene."""

        def take(target: ChosenFile | None) -> None:
            if target is not None:
                self._take_tables(target.path)

        def check(path: Path, _force: bool) -> None:
            read_over_time(path)

        dialog = PathDialog("Parameters over time", "", _TABLES, check, verb="Read")
        self._screen.app.push_screen(dialog, take)

    def _take_tables(self, path: Path) -> None:
        try:
            # A scene refuses tables that do not fit its parameters.
            scene = replace(self._session.scene(), over_time=read_over_time(path))
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
        else:
            words = f"tables over time from {path}"
            self._screen.post_message(TablesChosen(scene.over_time, words))

    def drop_tables(self) -> None:
        """Keep the parameters over time at their values at t = 0."""
        self._screen.post_message(TablesChosen((), "tables over time dropped"))

    def read_result(self) -> None:
        """Ask for a result file and read it."""

        def read(target: ChosenFile | None) -> None:
            if target is not None:
                self._read(target.path)

        def check(path: Path, _force: bool) -> None:
            check_readable(path)

        dialog = PathDialog("Read a result", "", _READABLE, check, verb="Read")
        self._screen.app.push_screen(dialog, read)

    def _read(self, path: Path) -> None:
        def work() -> None:
            try:
                kind = kind_of(path)
                if kind == "run":
                    message: Message = RunRead(path, *load_run(path))
                else:
                    study = DisplayedStudy(load_study(kind, path), path.stem, str(path))
                    message = StudyRead(kind, study)
            except InputError as error:
                message = Reported(str(error), error=True)
            self._screen.post_message(message)

        self._screen.run_worker(work, name="reading", thread=True, exit_on_error=False)


def _title(export: Export) -> str:
    return f"Export the {export.what} of {export.of}"


def _without_folder(words: str, folder: str) -> str:
    return words.replace(f"{folder}{os.sep}", "")


def download_name(path: Path) -> str:
    """The name under which a browser downloads a file: letters and digits without accents."""
    return "".join(c if (c.isascii() and c.isalnum()) or c in "-_." else "-" for c in path.name)


def _is_scene(path: Path) -> bool:
    return path.suffix.lower() == ".toml"

"""Opening and saving: dialogs on the screen, files in threads."""

from pathlib import Path

from textual.screen import Screen

from fivtui.core.errors import InputError
from fivtui.scene import load_scene

from .dialogs import PathDialog, Target
from .exports import EXPORTS, Export, check_scene_path, proposal, save_scene_as, write_export
from .messages import ExportEnded, Reported, SceneLoaded
from .runs import Run
from .session import Session


class FileDesk:
    """All that reads or writes files on behalf of a screen.

    Parameters
    ----------
    screen : Screen
        Shows the dialogs and gets the messages.
    session : Session
        Its scene is opened and saved.
    """

    def __init__(self, screen: Screen[None], session: Session) -> None:
        self._screen = screen
        self._session = session

    def export(self, what: str, run: Run) -> None:
        """Ask for a path and write something of a run there.

        Parameters
        ----------
        what : str
            A name in `EXPORTS`.
        run : Run
            A run that is done.
        """
        export = EXPORTS[what]

        def write(target: Target | None) -> None:
            if target is not None:
                self._write(export, run, target)

        dialog = PathDialog(
            f"Write the {what} of run {run.number}",
            proposal(run, export),
            f"The suffix says the format, for example {export.suffix}.",
            export.check,
        )
        self._screen.app.push_screen(dialog, write)

    def _write(self, export: Export, run: Run, target: Target) -> None:
        def work() -> None:
            error = write_export(export, run, target.path, force=target.force)
            self._screen.post_message(ExportEnded(export.what, target.path, error))

        self._screen.run_worker(work, name=export.what, thread=True, exit_on_error=False)

    def open_scene(self) -> None:
        """Ask for a scene file and load it."""

        def load(target: Target | None) -> None:
            if target is None:
                return
            try:
                scene = load_scene(target.path)
            except InputError as error:
                self._screen.post_message(Reported(str(error), error=True))
            else:
                self._screen.post_message(SceneLoaded(scene, str(target.path)))

        def check(path: Path, _force: bool) -> None:
            load_scene(path)

        dialog = PathDialog("Open a scene", "", "A scene file (.toml).", check, verb="Open")
        self._screen.app.push_screen(dialog, load)

    def save_scene(self) -> None:
        """Ask for a path and save the scene edited."""
        try:
            scene = self._session.scene()
        except InputError as error:
            self._screen.post_message(Reported(str(error), error=True))
            return

        def save(target: Target | None) -> None:
            if target is None:
                return
            try:
                named = save_scene_as(scene, target.path, force=target.force)
            except InputError as error:
                self._screen.post_message(Reported(str(error), error=True))
            else:
                self._screen.post_message(SceneLoaded(named, str(target.path)))

        dialog = PathDialog(
            "Save the scene as", f"{scene.name}.toml", "A scene file (.toml).", check_scene_path
        )
        self._screen.app.push_screen(dialog, save)

"""Actions on the scene as text: in the user's editor, and in files that other programs change."""

import os
import shlex
import shutil
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Final

from textual.app import App, SuspendNotSupported

from fivtui.model import InputError
from fivtui.scene import load_scene, save_scene, scene_file
from fivtui.tui.session import EditState
from fivtui.tui.tabs import SceneLoaded

from .file_actions import FileActions

# Editors without VISUAL and EDITOR, the preferred one first.
_EDITORS: Final = ("nano", "vim", "vi") if os.name == "posix" else ("notepad",)
_NO_EDITOR: Final = (
    "no editor: set the environment variable VISUAL or EDITOR to the command of one"
    f", or install {', '.join(_EDITORS)}"
)
_NO_TERMINAL: Final = "an editor needs a terminal: save the scene, and edit its file"
_UNCHANGED: Final = "scene not changed; an editor with a window must wait, as 'code --wait' does"

# A file, the time of its last change, and its size.
_Version = tuple[Path, int, int]


class EditorActions(FileActions):
    """Opens the scene in the user's editor, and offers to read its file again when it changes."""

    # A file that the editor left invalid, and the edits that it replaces: opened again.
    _draft: tuple[Path, EditState] | None = None
    # The version of the scene's file that was read, or whose reading was offered.
    _version: _Version | None = None
    _is_checking_file = False

    def action_edit_scene(self) -> None:
        """Edit the scene as text, and read it back.

        A scene without unsaved edits is edited in its file, any other in a temporary file.
        """
        with self.report_errors():
            if self.app.is_web:
                raise InputError(_NO_TERMINAL)
            command, keys = editor_command(os.environ), self.session.key_names
            file = scene_file(self.session.source)
            is_draft = file is None or not file.is_file() or bool(self.session.changed_fields)
            path = self._draft_file() if file is None or is_draft else file
            run_editor(self.app, command, path)
            if not is_draft:
                self._version = _version(path)
            try:
                scene = load_scene(path)
            except InputError as error:
                raise InputError(f"{error}; {keys['edit']} opens it again") from None
            if is_draft:
                shutil.rmtree(path.parent, ignore_errors=True)
                self._draft = None
            if scene == self.session.scene():
                self.report(_UNCHANGED)
            elif is_draft:
                self.session.replace_scene(scene)
                self.show_edit(f"scene read back; {keys['undo']} undoes")
            else:
                report = f"scene {scene.name} read from {path}; {keys['undo']} undoes"
                self.post_message(SceneLoaded(scene, str(path), report))

    def _draft_file(self) -> Path:
        # The file that the editor left invalid, unless the form has changed since; or a copy.
        if self._draft is None or self._draft[1] != self.session.edit_state:
            path = Path(mkdtemp(prefix="fivtui-")) / "scene.toml"
            save_scene(self.session.scene(), path)
            self._draft = path, self.session.edit_state
        return self._draft[0]

    def check_scene_file(self) -> None:
        """Offer to read the scene's file if another program has changed it; call at intervals."""
        file, loaded = scene_file(self.session.source), self.session.loaded
        last_version = self._version
        if file is None or self._is_checking_file:
            return
        self._is_checking_file = True

        def check() -> None:
            version, change = _version(file), ""
            if version not in (None, last_version):
                try:
                    if load_scene(file) != loaded:
                        change = f"{file} has changed on disk"
                except InputError as error:
                    change = f"changed on disk: {error}"
            self.call_later(offer, version, change)

        def offer(version: _Version | None, change: str) -> None:
            self._is_checking_file = False
            # The scene may have been saved, edited as text or replaced since.
            if self.session.loaded is loaded and self._version == last_version:
                self._version = version
                if change:
                    keys, has_edits = self.session.key_names, bool(self.session.changed_fields)
                    edits = f"; {keys['undo']} then brings your edits back" if has_edits else ""
                    self.report(f"{change}; {keys['reload']} reads it{edits}")

        # In a thread, because a file of a network may be slow.
        self.run_in_thread("watching", check)

    def action_reload_scene(self) -> None:
        """Read the scene's file again."""
        self.open_path(Path(self.session.source))


def _version(file: Path) -> _Version | None:
    # The version of a file; None if it cannot be read.
    try:
        status = file.stat()
    except OSError:
        return None
    return file, status.st_mtime_ns, status.st_size


def editor_command(environment: Mapping[str, str]) -> list[str]:
    """The command of the user's editor, or of an installed one; `InputError` if there is none."""
    text = environment.get("VISUAL") or environment.get("EDITOR") or ""
    try:
        command = shlex.split(text, posix=os.name == "posix")
    except ValueError:
        raise InputError(f"editor {text}: a quote is not closed") from None
    command = command or [*filter(shutil.which, _EDITORS)][:1]
    if not command:
        raise InputError(_NO_EDITOR)
    return command


def run_editor(app: App[Any], command: Sequence[str], path: Path) -> None:
    """Run an editor in the terminal; raises `InputError` if it fails."""
    problem = ""
    try:
        with app.suspend():
            # Ctrl+C is for the editor.
            handler = signal.signal(signal.SIGINT, lambda *_: None)
            try:
                status = subprocess.run(  # noqa: S603, the user's editor
                    [*command, str(path)], check=False
                ).returncode
                problem = f"ended with status {status}" if status else ""
            except OSError as error:
                problem = error.strerror or str(error)
            finally:
                signal.signal(signal.SIGINT, handler)
    except SuspendNotSupported:
        raise InputError(_NO_TERMINAL) from None
    if problem:
        raise InputError(f"editor {command[0]}: {problem}; the scene stays as it is")

"""The scene in the user's editor, and scene files that other programs change."""

import shutil
import signal
import sys
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui.model import InputError, Parameters
from fivtui.scene import PRESETS, load_scene, save_scene
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab import screen
from fivtui.tui.lab.editor_actions import editor_command
from tests.support.laboratory import (
    app_of,
    until,
    until_notice,
    until_shown,
)

Editor = Callable[[str], None]


@pytest.fixture
def editor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Editor:
    """Makes a Python program the editor; it edits `text`, or ends with `status`."""
    monkeypatch.setattr(FivtuiApp, "suspend", lambda _: nullcontext())

    def use(program: str) -> None:
        script = tmp_path / "editor.py"
        script.write_text(
            "import pathlib, sys\npath, status = pathlib.Path(sys.argv[1]), 0\n"
            f"text = path.read_text()\n{program}\npath.write_text(text)\nsys.exit(status)\n"
        )
        monkeypatch.setenv("VISUAL", f"{sys.executable} {script}")

    return use


async def edit(pilot: Pilot[None], notice: str) -> None:
    # `e` types a letter in an input, so leave it first.
    await pilot.press("escape", "e")
    await until_notice(pilot, notice)


async def test_a_scene_edited_as_text_is_one_undo_step(pilot: Pilot[None], editor: Editor) -> None:
    session = app_of(pilot).session
    editor("text = text.replace('mu = 0.7', 'mu = 0.25').replace('F = 80.0', 'F = 90.0')")
    await edit(pilot, "scene read back; Ctrl+Z undoes")
    assert (session.texts["mu"], session.texts["F"]) == ("0.25", "90")
    await until_shown(pilot, "base (changed)")
    await pilot.press("ctrl+z")
    await until(pilot, lambda: not session.changed_fields)
    # A name is no field of the form: the scene is another one, without a file.
    editor("text = text.replace('name = \"base\"', 'name = \"mine\"')")
    await edit(pilot, "scene read back")
    assert (session.name, session.source) == ("mine", "")


async def test_invalid_text_is_kept_for_the_next_call_and_changes_nothing(
    pilot: Pilot[None], editor: Editor
) -> None:
    session = app_of(pilot).session
    handler = signal.getsignal(signal.SIGINT)
    editor("text += 'c3 = 1.0 # mine'")
    await edit(pilot, "unknown")
    await until_shown(pilot, "e opens it again")
    assert not session.changed_fields
    editor("text = text.replace('c3 = 1.0 # mine', '').replace('mu = 0.7', 'mu = 0.1'); status = 3")
    await edit(pilot, "ended with status 3; the scene stays as it is")
    assert not session.changed_fields
    editor("")
    await edit(pilot, "scene read back")
    assert session.texts["mu"] == "0.1"
    await edit(pilot, "scene not changed")
    assert signal.getsignal(signal.SIGINT) is handler


async def test_an_editor_that_cannot_start_is_one_line(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("VISUAL", raising=False)
    monkeypatch.setenv("EDITOR", "ed")
    await edit(pilot, "an editor needs a terminal")
    monkeypatch.setattr(FivtuiApp, "suspend", lambda _: nullcontext())
    monkeypatch.setattr(shutil, "which", lambda _: None)
    for command, message in (
        ("", "no editor: set the environment variable VISUAL or EDITOR"),
        ("missing-editor -w", "editor missing-editor: No such file or directory"),
        ("'vi", "editor 'vi: a quote is not closed"),
    ):
        monkeypatch.setenv("EDITOR", command)
        await edit(pilot, message)


def test_visual_precedes_editor_and_an_installed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    assert editor_command({"VISUAL": "code --wait", "EDITOR": "ed"}) == ["code", "--wait"]
    assert editor_command({"VISUAL": "", "EDITOR": "ed"}) == ["ed"]
    installed = ["vi", "vim"]
    monkeypatch.setattr(shutil, "which", lambda name: name if name in installed else None)
    assert editor_command({"EDITOR": " "}) == ["vim"]
    installed.clear()
    with pytest.raises(InputError, match=r"no editor.* install nano, vim, vi$"):
        editor_command({})


def write_scene(path: Path, mu: float) -> None:
    scene = replace(PRESETS["base"], name="mine", parameters=Parameters(mu=mu))
    save_scene(scene, path, force=True)


async def test_an_unchanged_scene_is_edited_in_its_file(
    tmp_path: Path, editor: Editor, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.toml"
    write_scene(path, 0.4)
    monkeypatch.setattr(screen, "_WATCH_INTERVAL_S", 0.05)
    async with FivtuiApp(load_scene(path), str(path)).run_test(size=(100, 30)) as pilot:
        editor("text = text.replace('mu = 0.4', 'mu = 0.3') + '# note'")
        await edit(pilot, "scene mine read from")
        session = app_of(pilot).session
        assert path.read_text().endswith("# note")
        assert (session.texts["mu"], session.changed_fields) == ("0.3", [])
        editor("text += '\\nc3 = 1.0'")
        await edit(pilot, "unknown")
        assert session.texts["mu"] == "0.3"
        # What the editor has changed is not offered again.
        assert not any("on disk" in line for line in session.reports)


async def test_a_file_that_changes_on_disk_is_offered_once_and_loses_no_edits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine.toml"
    write_scene(path, 0.4)
    monkeypatch.setattr(screen, "_WATCH_INTERVAL_S", 0.05)
    async with FivtuiApp(load_scene(path), str(path)).run_test(size=(100, 30)) as pilot:
        session = app_of(pilot).session
        await pilot.press("up")
        # A saved scene is not offered.
        await pilot.press("ctrl+s")
        await until_notice(pilot, "scene mine saved")
        await pilot.press("up")
        write_scene(path, 0.25)
        await until_notice(pilot, "has changed on disk; Alt+D reads it; Ctrl+Z then brings your")
        assert session.texts["mu"] == "0.42"
        await pilot.press("alt+d")
        await until(pilot, lambda: session.texts["mu"] == "0.25")
        assert not session.changed_fields
        await pilot.press("ctrl+z")
        await until(pilot, lambda: session.texts["mu"] == "0.42")
        invalid = tmp_path / "invalid.toml"
        invalid.write_text("mu")
        invalid.replace(path)
        await until_notice(pilot, "changed on disk: ")
        await pilot.press("alt+d")
        await until_notice(pilot, "not a TOML file")
        assert session.texts["mu"] == "0.42"
        assert sum("changed on disk" in line for line in session.reports) == 2

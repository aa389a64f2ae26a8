"""Each instance of the laboratory has its own session, and no instance loses stored results."""

import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui.io import writing
from fivtui.maps import stability_map
from fivtui.model.errors import InputError
from fivtui.scene.presets import PRESETS
from fivtui.tui import start
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.run_actions import RunActions
from fivtui.tui.persistence.autosave import Autosave
from fivtui.tui.persistence.slots import slot_of
from fivtui.tui.persistence.state_file import State, session_state
from fivtui.tui.session.runs import MAX_RUNS
from fivtui.tui.session.session import DisplayedStudy, Session
from tests.support.laboratory import (
    app_of,
    until,
    until_notice,
    until_shown,
)

BASE = PRESETS["base"]
# A process that opens a session, prints its number, stores a map in it, and waits to be killed.
INSTANCE_CODE = """
import sys
from pathlib import Path
from tests.tui.persistence.test_slots import state_with_map
from fivtui.tui.persistence.autosave import Autosave
autosave = Autosave(Path(sys.argv[1]))
autosave.load()
autosave.save(state_with_map(sys.argv[2]))
print(autosave.number, flush=True)
sys.stdin.read()
"""


def state_with_map(preload: str) -> State:
    """The state of a session with a preload F, and a map named after it."""
    session = Session()
    session.set_text("F", preload)
    over = {"mu": np.linspace(0.0, 1.0, 3), "F": np.linspace(10.0, 20.0, 2)}
    session.studies["map"] = DisplayedStudy(stability_map(BASE.parameters, over), preload)
    return session_state(session)


def load_session(path: Path) -> tuple[Autosave, Session]:
    autosave = Autosave(path)
    session = autosave.load()
    assert session is not None
    assert not autosave.notices
    return autosave, session


def check_map_and_read_preload(autosave: Autosave, session: Session) -> str:
    """The preload F of a session whose map agrees with it and is complete."""
    results, errors = autosave.store.read(session.unread_results)
    assert not errors
    study: Any = results["map"]
    assert study.value.values.shape == (3, 2)
    assert study.name == session.texts["F"]
    return str(study.name)


@contextmanager
def start_instance(path: Path, preload: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", INSTANCE_CODE, str(path), preload]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        yield process
        process.kill()


def read_session_number(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def store_session(path: Path, preload: str, time: float) -> None:
    """Start and store a session, and close it with the modification time `time`."""
    autosave = Autosave(path)
    autosave.load()
    autosave.save(state_with_map(preload))
    slot = slot_of(path, autosave.number)
    autosave.close(state_with_map(preload))
    os.utime(slot.path, (time, time))


def test_two_simultaneous_instances_have_separate_sessions(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    with start_instance(path, "11") as process:
        assert read_session_number(process) == "1"
        own_session = Autosave(path)
        assert own_session.load() is None
        assert (own_session.number, [slot.number for slot in own_session.other_slots]) == (2, [1])
        own_session.save(state_with_map("22"))
        own_session.close(state_with_map("23"))
        with pytest.raises(InputError, match="is in use by another fivtui"):
            Autosave(path).open(1)
        process.send_signal(signal.SIGKILL)
        process.wait()
    os.utime(path, (1.0, 1.0))
    # The system has released the lock; the session used last comes first.
    latest_session, session = load_session(path)
    assert check_map_and_read_preload(latest_session, session) == "23"
    earlier_session, session = load_session(path)
    assert check_map_and_read_preload(earlier_session, session) == "11"
    new_session = Autosave(path)
    assert new_session.load() is None
    assert new_session.number == 3
    assert len(list(tmp_path.rglob("map-*.npz"))) == 2


def test_the_last_used_session_is_restored_and_all_others_can_be_opened(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    first, second = Autosave(path), Autosave(path)
    for autosave, preload in ((first, "11"), (second, "22")):
        autosave.load()
        autosave.save(state_with_map(preload))
    for autosave, preload, time in ((first, "11", 100.0), (second, "22", 300.0)):
        slot = slot_of(path, autosave.number)
        autosave.close(state_with_map(preload))
        os.utime(slot.path, (time, time))
    autosave, session = load_session(path)
    assert check_map_and_read_preload(autosave, session) == "22"
    assert (autosave.number, [slot.number for slot in autosave.other_slots]) == (2, [1])
    opened = Autosave(path)
    earlier_session = opened.open(autosave.other_slots[0].number)
    assert check_map_and_read_preload(opened, earlier_session) == "11"
    with pytest.raises(InputError, match="session 7 no longer exists"):
        Autosave(path).open(7)


def stored_preload(path: Path) -> str:
    return str(json.loads(path.read_text())["edits"]["texts"]["F"])


def test_a_session_without_a_lock_file_is_restored_with_its_results(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    store_session(path, "11", 100.0)
    path.with_name("session.lock").unlink()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["results", "session.json"]
    autosave, session = load_session(path)
    assert (autosave.number, check_map_and_read_preload(autosave, session)) == (1, "11")


@pytest.mark.parametrize("content", ["{", '{"fivtui_session": 1}', '{"fivtui_session": 99}'])
def test_the_results_of_a_renamed_session_stay(content: str, tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    store_session(path, "11", 100.0)
    original = path.read_text()
    path.write_text(content)
    autosave = Autosave(path)
    assert autosave.load() is None
    autosave.save(state_with_map("22"))
    autosave.save(state_with_map("33"))
    autosave.close(state_with_map("44"))
    # After repair by hand everything is restored.
    (tmp_path / "session.unread-1.json").write_text(original)
    (tmp_path / "session.unread-1.json").replace(path)
    repaired_session, session = load_session(path)
    assert check_map_and_read_preload(repaired_session, session) == "11"


def test_without_a_lock_a_new_session_begins_that_is_not_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "session.json"
    store_session(path, "11", 100.0)
    content = path.read_bytes()

    def raise_os_error(*_: Any) -> int:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(writing, "lock_file", raise_os_error)
    autosave = Autosave(path)
    assert autosave.load() is None
    assert autosave.notices == [autosave.save_error]
    assert os.strerror(errno.ENOLCK) in autosave.save_error
    autosave.save(state_with_map("22"))
    autosave.close(state_with_map("33"))
    assert path.read_bytes() == content
    assert [slot.number for slot in autosave.other_slots] == [1]


def test_a_full_disk_is_reported_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "session.json"
    store_session(path, "11", 100.0)
    autosave, _ = load_session(path)

    def raise_no_space(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    state = state_with_map("22")
    with monkeypatch.context() as patched:
        patched.setattr("fivtui.io.writing.os.fsync", raise_no_space)
        autosave.save(state)
        assert "No space left" in autosave.save_error
        assert stored_preload(path) == "11"
        assert not list(tmp_path.rglob("*.tmp"))
    autosave.close(state)
    assert not autosave.save_error
    second_session, reloaded = load_session(path)
    assert check_map_and_read_preload(second_session, reloaded) == "22"
    assert len(list((tmp_path / "results").iterdir())) == 1


def test_a_result_that_cannot_be_written_is_reported_and_written_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "session.json"
    store_session(path, "11", 100.0)
    autosave, _ = load_session(path)
    state = state_with_map("22")
    (tmp_path / "results").rename(tmp_path / "gone")
    (tmp_path / "results").write_text("in the way")
    autosave.save(state)
    error = f"map is not saved: {tmp_path / 'results'}: cannot be made a folder"
    assert autosave.save_error.startswith(error)
    (tmp_path / "results").unlink()
    autosave.close(state)
    assert not autosave.save_error
    second_session, reloaded = load_session(path)
    assert check_map_and_read_preload(second_session, reloaded) == "22"


def test_a_state_folder_that_cannot_be_created_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    autosave = Autosave(tmp_path / "file" / "fivtui" / "session.json")
    assert autosave.load() is None
    assert "cannot be made a folder" in autosave.save_error
    autosave.save(state_with_map("1"))
    assert "cannot be made a folder" in autosave.save_error
    autosave.close(state_with_map("2"))


def test_a_session_that_was_not_saved_is_reported_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fivtui").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(FivtuiApp, "run", lambda _: None)
    # Settings of the whole process must not affect other tests.
    monkeypatch.setattr("gc.disable", lambda: None)
    monkeypatch.setattr("sys.setswitchinterval", lambda _: None)
    start.run()
    error_text = capsys.readouterr().err
    assert error_text.startswith(f"the session is not saved: {tmp_path / 'fivtui'}: cannot be made")


def test_a_run_that_leaves_the_list_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    reports: list[str] = []
    lab = RunActions(Session())
    monkeypatch.setattr(lab, "post_message", lambda _: None)
    monkeypatch.setattr(lab, "run_worker", lambda *_, **__: None)
    monkeypatch.setattr(lab, "action_show_tab", lambda _: None)
    monkeypatch.setattr(lab, "report", reports.append)
    for _ in range(MAX_RUNS + 1):
        lab.action_run()
    assert reports == [f"run 1 (the oldest) was deleted: the list holds {MAX_RUNS} runs"]


async def test_the_palette_opens_another_session_and_keeps_this_one(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    with start_instance(path, "11") as process:
        assert read_session_number(process) == "1"
        app = FivtuiApp(state=path)
        async with app.run_test(size=(100, 30)) as pilot:
            await until_notice(pilot, "session 2; other saved sessions: 1 (Ctrl+P, Open)")
            app.session.set_text("F", "22")
            await open_from_palette(pilot, "Open session 1: scene base, map")
            await until_notice(pilot, "is in use by another fivtui")
            assert app.session.texts["F"] == "22"
            process.kill()
            process.wait()
            await open_from_palette(pilot, "Open session 1: scene base, map")
            await until_notice(pilot, "session 1 opened")
            assert app_of(pilot).session.texts["F"] == "11"
            await until(pilot, lambda: app.session.studies.get("map") is not None)
            await until_shown(pilot, "base (changed)")
            await pilot.press("alt+1")
            await until_shown(pilot, "Run keeps it")
            assert len(app.screen_stack) == 1
    autosave, session = load_session(path)
    assert (autosave.number, check_map_and_read_preload(autosave, session)) == (1, "11")
    assert stored_preload(tmp_path / "session-2" / "session.json") == "22"


async def open_from_palette(pilot: Any, title: str) -> None:
    await pilot.press("ctrl+p")
    await until_shown(pilot, "Run the scene and keep the run")
    # The search finds "Open session" without the blank, which is no name of a key.
    await pilot.press(*"opensession")
    await until_shown(pilot, title)
    await pilot.press("enter")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a kill in the midst needs a fork")
def test_a_session_is_complete_after_a_kill_at_any_operation(tmp_path: Path) -> None:
    # The number of file operations, at each of which a process was killed.
    assert int(run_kill_test("session_kill", "autosave", str(tmp_path))) > 20


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a kill in the midst needs a fork")
def test_no_kill_of_the_laboratory_loses_a_run(tmp_path: Path) -> None:
    assert run_kill_test("session_kill", "lab", str(tmp_path), "2") == "2"


@pytest.mark.host
@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="processes are found by /proc")
# Numbers of kills, and of instances in terminals.
@pytest.mark.parametrize(
    ("kills", "terminals"), [("1", "1"), pytest.param("100", "2", marks=pytest.mark.whole)]
)
def test_kills_beside_other_instances_and_a_browser_lose_no_run(
    kills: str, terminals: str, tmp_path: Path
) -> None:
    pytest.importorskip("textual_serve", reason="the extra serve is not installed")
    # The number of runs that are stored after kills among several instances.
    assert int(run_kill_test("session_crowd", str(tmp_path), kills, terminals)) > 0


def run_kill_test(module: str, *arguments: str) -> str:
    command = [sys.executable, "-m", f"tests.support.{module}", *arguments]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stderr
    return process.stdout.strip()

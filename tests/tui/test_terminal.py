"""The program in a real terminal: tmux sends keys and returns the screen."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import fivtui
from tests.support.laboratory import HANG_S
from tests.support.pseudo_terminal import start_laboratory

# The wait fails after this number of polls, or after HANG_S. Late polls are not counted, because
# the machine was busy.
MAX_POLLS = 2000
POLL_INTERVAL_S = 0.05
LATE_POLL_S = 0.2
EXIT_TEXT = "ended with"
# Flags of tmux: alternate screen, mouse tracking, visible cursor.
TERMINAL_MODES = "#{alternate_on} #{mouse_any_flag} #{cursor_flag}"
TMUX = shutil.which("tmux")


class Terminal:
    """An 80 by 24 terminal that runs the program."""

    def __init__(self, folder: Path) -> None:
        self._base = [str(TMUX), "-L", f"fivtui-{os.getpid()}-{folder.name}", "-f", os.devnull]
        environment = os.environ | {
            "XDG_STATE_HOME": str(folder),
            "LC_ALL": "C.UTF-8",
            "PYTHONPATH": str(Path(fivtui.__file__).parents[1]),
        }
        shell_command = f"cd {folder} && {sys.executable} -m fivtui; echo {EXIT_TEXT} $?; cat"
        self._tmux("new-session", "-d", "-x", "80", "-y", "24", shell_command, env=environment)

    def _tmux(self, *arguments: str, env: dict[str, str] | None = None) -> str:
        command = [*self._base, *arguments]
        process = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
        return process.stdout

    def press(self, *keys: str) -> None:
        self._tmux("send-keys", *keys)

    def screen(self) -> str:
        return self._tmux("capture-pane", "-p")

    def until_shown(self, phrase: str) -> str:
        start_time = previous_time = time.monotonic()
        poll_count = 0
        while phrase not in " ".join((screen_text := self.screen()).split()):
            current_time = time.monotonic()
            poll_count += current_time - previous_time < LATE_POLL_S
            previous_time = current_time
            has_exited = EXIT_TEXT in screen_text and EXIT_TEXT not in phrase
            has_failed = has_exited or poll_count > MAX_POLLS or current_time - start_time > HANG_S
            assert not has_failed, f"{phrase!r} did not come; the screen:\n{screen_text}"
            time.sleep(POLL_INTERVAL_S)
        return screen_text

    def format(self, template: str) -> str:
        return self._tmux("display-message", "-p", template).strip()

    def program_id(self) -> int:
        command = ["pgrep", "-P", self.format("#{pane_pid}")]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    def close_terminal(self) -> None:
        self._tmux("kill-pane")

    def close(self) -> None:
        subprocess.run([*self._base, "kill-server"], check=False, capture_output=True)


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    if TMUX is None:
        pytest.skip("no tmux")
    started_terminal = Terminal(tmp_path)
    yield started_terminal
    started_terminal.close()


@pytest.mark.host
def test_a_real_terminal_shows_edits_runs_and_exports(terminal: Terminal, tmp_path: Path) -> None:
    terminal.until_shown("UNSTABLE: growth rate +0.6304 1/s")
    terminal.press("Up")
    terminal.until_shown("base (changed)")
    terminal.press("C-z")
    terminal.until_shown("μ 0.7 − +")
    # Keys with Alt are not text, and these change nothing.
    terminal.press("M-7", "M-0", "M-x")
    terminal.press("M-s")
    terminal.until_shown("Save the scene as")
    terminal.press("Escape")
    terminal.until_shown("μ 0.7 − +")
    terminal.press("F5")
    screen_text = terminal.until_shown("amplitude of y ±4.401 m, still falling")
    assert any("⠁" <= character <= "⣿" for character in screen_text)
    # Focus the plot, then the fields: a step of a field draws a run that only F5 would keep.
    terminal.press("M-p", "M-f", "Up")
    terminal.until_shown("Run keeps it")
    # Two cursors show values.
    terminal.press("M-p", "c", "C")
    terminal.until_shown("t ◆50 ◇75 s Δt 25 s 1/Δt 0.04 Hz")
    terminal.press("Escape")
    terminal.until_shown("amplitude of y")
    terminal.press("C-z")
    terminal.until_shown("run 1 done")
    terminal.press("F3")
    terminal.until_shown("● 1 shown 10.50")
    terminal.press("M-0")
    terminal.until_shown("what it shows")
    terminal.press("M-1")
    terminal.until_shown("amplitude of y ±4.401 m")
    terminal.press("F7")
    terminal.until_shown("Export the data of run 1")
    terminal.press("Enter")
    terminal.until_shown("data written to")
    assert (tmp_path / "base-1.csv").is_file()
    terminal.press("C-q")
    terminal.until_shown("ended with 0")
    assert (tmp_path / "fivtui" / "session.json").is_file()


@pytest.mark.host
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_saves_the_session_and_restores_the_terminal(
    number: signal.Signals, terminal: Terminal, tmp_path: Path
) -> None:
    terminal.until_shown("UNSTABLE: growth rate +0.6304 1/s")
    assert terminal.format(TERMINAL_MODES) == "1 1 0"
    terminal.press("Up", "Up")
    terminal.until_shown("μ 0.72")
    os.kill(terminal.program_id(), number)
    terminal.until_shown(f"ended with {128 + number}")
    assert terminal.format(TERMINAL_MODES) == "0 0 1"
    assert '"mu": "0.72"' in (tmp_path / "fivtui" / "session.json").read_text()


@pytest.mark.host
def test_a_closed_terminal_saves_the_session(terminal: Terminal, tmp_path: Path) -> None:
    terminal.until_shown("UNSTABLE: growth rate +0.6304 1/s")
    terminal.press("Up", "Up")
    terminal.until_shown("μ 0.72")
    program_id = terminal.program_id()
    terminal.close_terminal()
    while Path(f"/proc/{program_id}").exists():
        time.sleep(POLL_INTERVAL_S)
    assert '"mu": "0.72"' in (tmp_path / "fivtui" / "session.json").read_text()


@pytest.mark.host
def test_a_program_whose_terminal_is_closed_without_a_signal_ends(tmp_path: Path) -> None:
    environment = os.environ | {"XDG_STATE_HOME": str(tmp_path)}
    process, controller = start_laboratory(environment, 24, 80)
    output = b""
    while b"UNSTABLE" not in output:
        output += os.read(controller, 65536)
    os.close(controller)
    # It writes the live run, or the cursor's next blink.
    assert process.wait(HANG_S) == 128 + signal.SIGHUP
    assert (tmp_path / "fivtui" / "session.json").is_file()

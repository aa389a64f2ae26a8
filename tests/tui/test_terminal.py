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

# The wait fails after this many polls. Polls that come late because the machine is busy are not
# counted. HANG_S ends a hang.
LOOKS = 2000
LOOK_S = 0.05
LATE_S = 0.2
ENDED = "ended with"
# Alternate screen, mouse tracking, visible cursor.
MODES = "#{alternate_on} #{mouse_any_flag} #{cursor_flag}"
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
        begin = f"cd {folder} && {sys.executable} -m fivtui; echo {ENDED} $?; cat"
        self._tmux("new-session", "-d", "-x", "80", "-y", "24", begin, env=environment)

    def _tmux(self, *arguments: str, env: dict[str, str] | None = None) -> str:
        command = [*self._base, *arguments]
        process = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
        return process.stdout

    def press(self, *keys: str) -> None:
        self._tmux("send-keys", *keys)

    def screen(self) -> str:
        return self._tmux("capture-pane", "-p")

    def until_shown(self, phrase: str) -> str:
        begin = previous = time.monotonic()
        looks = 0
        while phrase not in " ".join((shown := self.screen()).split()):
            current = time.monotonic()
            looks += current - previous < LATE_S
            previous = current
            ended = ENDED in shown and ENDED not in phrase
            in_vain = ended or looks > LOOKS or current - begin > HANG_S
            assert not in_vain, f"{phrase!r} did not come; the screen:\n{shown}"
            time.sleep(LOOK_S)
        return shown

    def format(self, template: str) -> str:
        return self._tmux("display-message", "-p", template).strip()

    def program(self) -> int:
        children = ["pgrep", "-P", self.format("#{pane_pid}")]
        return int(subprocess.run(children, check=True, capture_output=True, text=True).stdout)

    def close_terminal(self) -> None:
        self._tmux("kill-pane")

    def close(self) -> None:
        subprocess.run([*self._base, "kill-server"], check=False, capture_output=True)


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    if TMUX is None:
        pytest.skip("no tmux")
    started = Terminal(tmp_path)
    yield started
    started.close()


@pytest.mark.host
def test_a_session_in_a_real_terminal(terminal: Terminal, tmp_path: Path) -> None:
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
    shown = terminal.until_shown("peak |y| 10.50 m · 2nd half ±4.401 m")
    assert "⣿" in shown
    # Move from the plot to the fields: each step updates the curve. Two cursors show values.
    terminal.press("M-p", "M-f", "Up")
    terminal.until_shown("F5 keeps a run")
    terminal.press("M-p", "c", "C")
    terminal.until_shown("t ◆50 ◇75 s Δt 25 s 1/Δt 0.04 Hz")
    terminal.press("Escape")
    terminal.until_shown("peak |y|")
    terminal.press("C-z")
    terminal.until_shown("run 1 done")
    terminal.press("F3")
    terminal.until_shown("● 1 shown 10.50")
    terminal.press("M-6")
    terminal.until_shown("what it shows")
    terminal.press("M-2")
    terminal.until_shown("peak |y| 10.50 m")
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
    assert terminal.format(MODES) == "1 1 0"
    terminal.press("Up", "Up")
    terminal.until_shown("μ 0.72")
    os.kill(terminal.program(), number)
    terminal.until_shown(f"ended with {128 + number}")
    assert terminal.format(MODES) == "0 0 1"
    assert '"mu": "0.72"' in (tmp_path / "fivtui" / "session.json").read_text()


@pytest.mark.host
def test_a_closed_terminal_saves_the_session(terminal: Terminal, tmp_path: Path) -> None:
    terminal.until_shown("UNSTABLE: growth rate +0.6304 1/s")
    terminal.press("Up", "Up")
    terminal.until_shown("μ 0.72")
    program = terminal.program()
    terminal.close_terminal()
    while Path(f"/proc/{program}").exists():
        time.sleep(LOOK_S)
    assert '"mu": "0.72"' in (tmp_path / "fivtui" / "session.json").read_text()

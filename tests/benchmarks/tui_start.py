"""How long the terminal UI needs to be there: a process in a terminal of its own.

What counts is what a user has: the form, the verdict and the charts of the tab in sight with the
right numbers, and then the answer to a key.
"""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import fivtui

ROOT: Final = Path(fivtui.__file__).parents[1]
PATIENCE_S: Final = 60.0
# Of the form, of the verdict and of the chart below it, in the base scene.
SHOWN: Final = ("Parameters", "UNSTABLE: growth rate +0.6304", "Re λ / 1/s")
KEY: Final = b"\x1b[A"
ANSWER: Final = "(changed)"
_CODES: Final = re.compile(
    rb"\x1b(\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)|P[^\x1b]*\x1b\\|.)"
)
_TICKS: Final = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Start:
    """Seconds from the start of a process.

    Attributes
    ----------
    shown, answered : float
        Until the screen was there, until the answer to a key pressed then.
    processor : float
        CPU time until the screen was there.
    """

    shown: float
    answered: float
    processor: float


class _Terminal:
    def __init__(self, columns: int, rows: int) -> None:
        self._master, self._slave = pty.openpty()
        fcntl.ioctl(self._slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self._out = b""

    def start(self, environment: dict[str, str]) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", "fivtui"],
            stdin=self._slave,
            stdout=self._slave,
            stderr=self._slave,
            env=environment,
            start_new_session=True,
        )

    def press(self, key: bytes) -> None:
        os.write(self._master, key)

    def until_shown(self, words: tuple[str, ...]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not all(part in self._text() for part in words):
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise TimeoutError(f"{words} did not come: {self._text()}")
            if select.select([self._master], [], [], left)[0]:
                self._out += os.read(self._master, 1 << 16)

    def drain(self, process: "subprocess.Popen[bytes]") -> None:
        # A process that cannot write does not end.
        while process.poll() is None:
            if select.select([self._master], [], [], 0.05)[0]:
                os.read(self._master, 1 << 16)

    def _text(self) -> str:
        return _CODES.sub(b"", self._out).decode(errors="replace")

    def close(self) -> None:
        os.close(self._master)
        os.close(self._slave)


def _processor(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


def _start(environment: dict[str, str], size: tuple[int, int]) -> Start:
    terminal = _Terminal(*size)
    begin = time.perf_counter()
    process = terminal.start(environment)
    try:
        terminal.until_shown(SHOWN)
        shown, processor = time.perf_counter() - begin, _processor(process.pid)
        terminal.press(KEY)
        terminal.until_shown((ANSWER,))
        answered = time.perf_counter() - begin - shown
        terminal.press(b"\x11")
        terminal.drain(process)
    finally:
        process.kill()
        process.wait()
        terminal.close()
    return Start(shown, answered, processor)


def starts(repeats: int, size: tuple[int, int] = (80, 24)) -> list[Start]:
    """Starts of the program, after one that leaves byte code as an installation does.

    Parameters
    ----------
    repeats : int
        How many.
    size : (int, int)
        Columns and rows of the terminal.
    """
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            **{
                name: value
                for name, value in os.environ.items()
                if name != "PYTHONDONTWRITEBYTECODE"
            },
            "PYTHONPATH": str(ROOT),
            "PYTHONPYCACHEPREFIX": f"{folder}/bytecode",
            "XDG_STATE_HOME": f"{folder}/state",
            "TERM": "xterm-256color",
            "LC_ALL": "C.UTF-8",
        }
        found: list[Start] = []
        for _ in range(repeats + 1):
            # Every start is the first one: no session is restored.
            environment["XDG_STATE_HOME"] = f"{folder}/state{len(found)}"
            found.append(_start(environment, size))
    return found[1:]

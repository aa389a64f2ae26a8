"""How long the terminal UI needs: a process in a terminal of its own, typed to and read.

What counts is what a user has: first the form, the verdict and the charts of the tab in sight with
the right numbers, then what a key changed, on the screen.
"""

import fcntl
import os
import pty
import random
import re
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import fivtui

ROOT: Final = Path(fivtui.__file__).parents[1]
PATIENCE_S: Final = 30.0
# Of the form, of the verdict and of the chart below it, in the base scene.
SHOWN: Final = ("Parameters", "UNSTABLE: growth rate +0.6304", "Re λ / 1/s")
ANSWER: Final = "(changed)"
UP: Final = b"\x1b[A"
BACKSPACE: Final = b"\x7f"
QUIT: Final = b"\x11"
COMPUTE: Final = b"\x1b[21~"
# Typed into the first field, in place of what it says; no other number shown begins like that.
BEFORE: Final = "5.73"
DIGITS: Final = "91827364"
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

    def start(self, words: Sequence[str], environment: dict[str, str]) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, *words],
            stdin=self._slave,
            stdout=self._slave,
            stderr=self._slave,
            env=environment,
            start_new_session=True,
        )

    def press(self, key: bytes) -> None:
        os.write(self._master, key)

    def forget(self) -> None:
        self._out = b""

    def pause(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            if select.select([self._master], [], [], left)[0]:
                self._out += os.read(self._master, 1 << 16)

    def until_shown(self, words: Sequence[str]) -> None:
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


@contextmanager
def _terminal(
    words: Sequence[str], environment: dict[str, str], size: tuple[int, int]
) -> Iterator[tuple[_Terminal, "subprocess.Popen[bytes]"]]:
    terminal = _Terminal(*size)
    process = terminal.start(words, environment)
    try:
        yield terminal, process
        terminal.press(QUIT)
        terminal.drain(process)
    finally:
        process.kill()
        process.wait()
        terminal.close()


def _start(environment: dict[str, str], size: tuple[int, int]) -> Start:
    begin = time.perf_counter()
    with _terminal(["-m", "fivtui"], environment, size) as (terminal, process):
        terminal.until_shown(SHOWN)
        shown, processor = time.perf_counter() - begin, _processor(process.pid)
        terminal.press(UP)
        terminal.until_shown([ANSWER])
        return Start(shown, time.perf_counter() - begin - shown, processor)


def _environment(folder: str) -> dict[str, str]:
    kept = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | {
        "PYTHONPATH": str(ROOT),
        "PYTHONPYCACHEPREFIX": f"{folder}/bytecode",
        "XDG_STATE_HOME": f"{folder}/state",
        "TERM": "xterm-256color",
        "LC_ALL": "C.UTF-8",
    }


def starts(repeats: int, size: tuple[int, int] = (80, 24)) -> list[Start]:
    """Starts of the program, after one that leaves byte code as an installation does.

    Parameters
    ----------
    repeats : int
        How many.
    size : (int, int)
        Columns and rows of the terminal.
    """
    found: list[Start] = []
    with tempfile.TemporaryDirectory() as folder:
        environment = _environment(folder)
        for number in range(repeats + 1):
            # Every start is the first one: no session is restored.
            environment["XDG_STATE_HOME"] = f"{folder}/state{number}"
            found.append(_start(environment, size))
    return found[1:]


@dataclass(frozen=True, slots=True)
class Load:
    """What is computed while keys are pressed.

    Attributes
    ----------
    what : str
        In words.
    keys : bytes
        What begins it.
    sign : str
        What the screen shows then.
    scene : str
        Fields of the base scene that are others, as Python.
    setting : str
        Python to execute before.
    """

    what: str
    keys: bytes = b""
    sign: str = ""
    scene: str = ""
    setting: str = ""


_INTERPRETED: Final = "from tests.support.kernels import INTERPRETED; INTERPRETED.start()"
LOADS: Final = (
    Load("nothing"),
    Load("a run, interpreted", b"\x1b[15~", "left", "t_end=1e6", _INTERPRETED),
    Load("a run, compiled", b"\x1b[15~", "left", "t_end=1e7"),
    Load("a run by rk4", b"\x1b[15~", "left", "t_end=1e3, method='rk4'"),
    Load("a sweep", b"\x1b3" + COMPUTE, "left", "t_end=1e5"),
    Load(
        "a map at every key",
        b"\x1b4",
        "1000000 points",
        setting="from fivtui.tui.tabs.charts import map as its; "
        "its.EXAMPLE = 'mu=0:1.5:1000 F=5:120:1000'",
    ),
    Load("a trade-off", b"\x1b5" + COMPUTE, "left", "t_end=1e3"),
)
_CHILD: Final = """
import dataclasses
from fivtui.scene.presets import PRESETS
from fivtui.tui.start import run
{setting}
run(dataclasses.replace(PRESETS["base"], {scene}))
"""


def answers(load: Load, repeats: int, size: tuple[int, int] = (80, 24)) -> list[float]:
    """From a key to what it changed on the screen, s, while something is computed.

    Parameters
    ----------
    load : Load
        What is computed.
    repeats : int
        How many keys.
    size : (int, int)
        Columns and rows of the terminal.
    """
    found: list[float] = []
    chosen = random.Random(3)
    code = _CHILD.format(setting=load.setting, scene=load.scene)
    with (
        tempfile.TemporaryDirectory() as folder,
        _terminal(["-c", code], _environment(folder), size) as (terminal, _),
    ):
        terminal.until_shown(SHOWN)
        for digit in BEFORE:
            terminal.press(digit.encode())
        terminal.until_shown([f"{BEFORE}"])
        if load.sign:
            terminal.forget()
            terminal.press(load.keys)
            terminal.until_shown([load.sign])
        while len(found) < repeats:
            for count in range(1, len(DIGITS) + 1):
                terminal.pause(chosen.uniform(0.1, 0.2))
                terminal.forget()
                begin = time.perf_counter()
                terminal.press(DIGITS[count - 1].encode())
                terminal.until_shown([f"{BEFORE}{DIGITS[:count]}"])
                found.append(time.perf_counter() - begin)
            terminal.press(BACKSPACE * len(DIGITS))
            terminal.pause(0.5)
    return found[:repeats]

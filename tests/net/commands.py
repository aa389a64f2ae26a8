"""Records output and written files of command lines, by group."""

import contextlib
import functools
import io
import itertools
import json
import os
import shlex
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from unittest import mock

from fivtui.cli import run
from tests.net.files import file_lines
from tests.net.text import SECTION_MARK, data_lines, mask_varying

FOLDER: Final = Path(__file__).parent
# The stress tests that are recorded; all of them would take minutes.
STRESS_TESTS: Final = ("rest-on-switch", "lifted", "tol-too-small")
# The methods that undergo them; `fmu` is the FMU with Python code.
STRESSED_METHODS: Final = ("taylor", "taylor-interpreted", "rk4", "fmu")
# A power of two, so that differences of times are exact.
_TICK_S: Final = 2.0**-20


def read_groups() -> dict[str, list[str]]:
    """The command lines of `commands.txt` by group."""
    groups: dict[str, list[str]] = {}
    for line in (FOLDER / "commands.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            groups[line.strip("[]")] = []
        elif line and not line.startswith("#"):
            groups[list(groups)[-1]].append(line)
    return groups


def record_commands(group: str) -> str:
    """Output and files of the command lines of a group, run in one folder."""
    parts = []
    with reproducible(), tempfile.TemporaryDirectory(prefix="fivtui-net-") as name:
        folder = Path(name).resolve()
        for source in (FOLDER / "inputs").iterdir():
            shutil.copy(source, folder)
        with contextlib.chdir(folder):
            for line in read_groups()[group]:
                parts += [f"{SECTION_MARK}fivtui {line}", *_run_and_describe(line, folder)]
    return "\n".join(parts) + "\n"


@contextlib.contextmanager
def reproducible() -> Iterator[None]:
    """Use clocks that count calls, help of a fixed width, and shortened long computations."""
    ticks = itertools.count()

    def counting_clock() -> float:
        return next(ticks) * _TICK_S

    # The stress tests of the command `extremes`.
    import fivtui.assessment

    few_tests = functools.partial(
        fivtui.assessment.run_stress_tests, STRESS_TESTS, STRESSED_METHODS
    )
    with contextlib.ExitStack() as stack:
        for name in ("thread_time", "process_time", "perf_counter"):
            stack.enter_context(mock.patch.object(time, name, counting_clock))
        # A trade-off measures the CPU time of each run once, not as the least of several.
        stack.enter_context(mock.patch("fivtui.tradeoffs.measure._MOST_REPEATS", 1))
        stack.enter_context(mock.patch("fivtui.assessment.run_stress_tests", few_tests))
        stack.enter_context(mock.patch.dict(os.environ, {"COLUMNS": "100"}))
        # This variable turns the message of an unexpected error into a traceback.
        os.environ.pop("FIVTUI_TRACEBACK", None)
        yield


def _run_and_describe(line: str, folder: Path) -> Iterator[str]:
    # Exit code, output and changed files of a command line that runs in the folder.
    states_before = _file_states(folder)
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        code = run(shlex.split(line))
    yield f"exit {code}"
    printed = out.getvalue()
    if printed.startswith(("{", "[")):
        printed = "\n".join(data_lines(json.loads(printed)))
    yield from mask_varying(printed, folder).splitlines()
    if errors := mask_varying(error.getvalue(), folder):
        yield from (f"stderr: {line}" for line in errors.splitlines())
    states_after = _file_states(folder)
    for path in sorted(states_after):
        if states_before.get(path) != states_after[path]:
            yield f"wrote {path.relative_to(folder)}"
            yield from (f"    {line}" for line in file_lines(path))
    for path in sorted(states_before.keys() - states_after.keys()):
        yield f"removed {path.relative_to(folder)}"


def _file_states(folder: Path) -> dict[Path, tuple[int, int]]:
    # Time of change and inode of every file; a file written anew differs in one of them.
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path: (path.stat().st_mtime_ns, path.stat().st_ino) for path in paths}

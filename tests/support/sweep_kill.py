"""Kills a sweep at its file operations, and lets it continue.

``python -m tests.support.sweep_kill FOLDER SUFFIX STRIDE`` kills it at every operation whose number
is a multiple of STRIDE, and prints the number of the last one. For CSV a second number follows, for
a sweep that overwrites a file. It fails if an incomplete output file is left. The operating system
kills the process, so no handler of the program runs.
"""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fivtui.io import output_path
from fivtui.model.parameters import Parameters
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.run import local_engine, sweep_to_file
from fivtui.sweeps.study import Study

STUDY = Study(
    Design({"F": Range(10.0, 120.0, 3)}), Parameters(), t_end=1.0, outputs=("y_abs", "separations")
)
# Prefixes of the audit events of file operations.
OPERATIONS = ("open", "os.")


def compute_sweep(out: Path, force: bool) -> None:
    sweep_to_file(STUDY, output_path(out, force=force), local_engine(1), size=2)


def kill_at(operation: int, folder: Path) -> None:
    """Have the operating system kill this process at its n-th file operation in a folder."""
    count = 0

    def hook(event: str, args: tuple[Any, ...]) -> None:
        nonlocal count
        if event.startswith(OPERATIONS) and str(folder) in str(args):
            count += 1
            if count == operation:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(hook)


def child(work: Callable[[], None]) -> int:
    """Run a function in a child process; return its exit code, minus the signal if it is killed."""
    process = os.fork()
    if process == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def check_kill(
    folder: Path, suffix: str, complete_bytes: bytes, operation: int, force: bool
) -> bool:
    """Kill a sweep at an operation and continue it; return whether it reached the operation."""
    out = folder / f"{operation}-{force}" / f"out{suffix}"
    out.parent.mkdir()
    if force:
        out.write_bytes(b"old")

    def run_until_killed() -> None:
        kill_at(operation, out.parent)
        compute_sweep(out, force)

    exit_code = child(run_until_killed)
    assert exit_code in (0, -signal.SIGKILL), exit_code
    assert not out.exists() or out.read_bytes() in (b"old", complete_bytes)
    assert child(lambda: compute_sweep(out, force)) == 0
    assert out.read_bytes() == complete_bytes
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    return exit_code != 0


def main() -> None:
    folder, suffix, stride = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    complete = folder / f"complete{suffix}"
    compute_sweep(complete, False)
    complete_bytes = complete.read_bytes()
    counts = []
    # Only CSV is tested with overwriting: replacement does not depend on the format.
    for force in (False, True) if suffix == ".csv" else (False,):
        operation = stride
        while check_kill(folder, suffix, complete_bytes, operation, force):
            operation += stride
        counts.append(operation - stride)
    print(*counts)


if __name__ == "__main__":
    main()

"""Runs the commands of the manual and returns what they print."""

import contextlib
import io
import shlex
import subprocess
import sys
from pathlib import Path

from fivtui.cli import run


class CommandError(Exception):
    """A command did not end as it should."""


def run_line(line: str, folder: Path) -> str:
    """What a command line prints in a folder, first on standard output, then on standard error.

    A script prints what it writes on standard output alone.
    """
    program, *arguments = shlex.split(line)
    if program == "python":
        return _run_script(arguments, folder)
    if program != "fivtui":
        raise CommandError(f"neither fivtui nor python: {program}")
    out, error = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(error),
    ):
        code = run(arguments)
    if code:
        raise CommandError(f"exit status {code}: {error.getvalue()}")
    # The folder is an accident of the build.
    return (out.getvalue() + error.getvalue()).rstrip().replace(f" in {folder}", "")


def _run_script(arguments: list[str], folder: Path) -> str:
    script = subprocess.run(  # noqa: S603, a script of the manual
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    if script.returncode:
        raise CommandError(f"exit status {script.returncode}: {script.stderr}")
    return script.stdout.rstrip()

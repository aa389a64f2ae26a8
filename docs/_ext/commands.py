"""Runs fivtui commands in this process and returns what they print."""

import contextlib
import io
import shlex
from pathlib import Path

from fivtui.cli import run


class CommandError(Exception):
    """A command did not end as it should."""


def run_line(line: str, folder: Path) -> str:
    """What a command line prints in a folder, first on standard output, then on standard error."""
    program, *arguments = shlex.split(line)
    out, error = io.StringIO(), io.StringIO()
    if program != "fivtui":
        raise CommandError(f"not a fivtui command: {program}")
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

"""Runs Python with the sources of this checkout in separate processes."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]


def run_python(
    *arguments: object,
    cwd: Path = ROOT,
    stdin: str = "",
    environment: Mapping[str, str] | None = None,
) -> str:
    """Standard output of Python, run with arguments and environment variables.

    Fails with the standard error unless the exit status is 0.
    """
    process = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(ROOT), **(environment or {})},
        input=stdin,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    return process.stdout

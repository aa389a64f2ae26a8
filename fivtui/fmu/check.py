"""Checks of an FMU: structure, model description, and a short run."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path, PurePosixPath
from typing import Final

from .instance import check_archive

# Limit of the wall-clock time of the short run, s.
_TIMEOUT_S: Final = 60.0


def check_fmu(path: str | Path) -> list[str]:
    """Check any FMU: structure, model description, and a short run in a separate process.

    Parameters
    ----------
    path : str or Path
        The FMU.

    Returns
    -------
    list of str
        The problems found, one line each; empty if there is none.

    Raises
    ------
    InputError
        If there is no such file, or it is not a zip archive with a model description.

    Examples
    --------
    >>> from fivtui import build_fmu, check_fmu
    >>> check_fmu(build_fmu("actuator.fmu", component="brake-actuator"))
    []
    """
    from fmpy.validation import validate_fmu

    path = Path(path)
    check_archive(path)
    problems = _find_structural_problems(path)
    problems += [" ".join(problem.split()) for problem in validate_fmu(str(path))]
    if not problems:
        problems = _find_run_problems(path)
    return problems


def _find_structural_problems(path: Path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        bad_file = archive.testzip()
    problems = [] if bad_file is None else [f"the file {bad_file} in the archive is damaged"]
    problems += [f"the archive holds {n} twice" for n, count in Counter(names).items() if count > 1]
    for name in names:
        parts = PurePosixPath(name).parts
        if "\\" in name or ":" in name or name.startswith("/") or ".." in parts:
            problems.append(f"the archive holds a file outside of the FMU: {name}")
    return problems


def _find_run_problems(path: Path) -> list[str]:
    # An FMU is foreign code that may crash its process: run it in another one.
    project_folder = str(Path(__file__).parents[2])
    import_path = os.pathsep.join(filter(None, (project_folder, os.environ.get("PYTHONPATH"))))
    with tempfile.TemporaryDirectory(prefix="fivtui-check-") as folder:
        try:
            process = subprocess.run(  # noqa: S603
                [sys.executable, "-m", "fivtui.fmu.probe", str(path.resolve())],
                cwd=folder,
                # Files that a killed process leaves are removed with the folder.
                env=os.environ | {"PYTHONPATH": import_path, "TMPDIR": folder},
                capture_output=True,
                timeout=_TIMEOUT_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return [f"a short run is not finished after {_TIMEOUT_S:g} s"]
    if process.returncode < 0:
        signal_name = signal.Signals(-process.returncode).name
        return [f"the FMU crashes the process that runs it ({signal_name})"]
    if process.returncode > 0:
        last_line = process.stderr.decode(errors="replace").strip().splitlines()[-1:]
        return [f"the FMU cannot be run: {' '.join(last_line)}"]
    problems: list[str] = json.loads(process.stdout.splitlines()[-1])
    return problems

"""Any command line exits with 0, 2 or 3; a failure leaves no files and prints one line,
below the warnings that were printed before it.
"""

import contextlib
import io
import shlex
import shutil
import tempfile
from pathlib import Path

import pytest

from fivtui.cli import run
from tests.support.command_lines import create_files, lines

ROOT = Path(__file__).parents[2]
MAX_MESSAGE_LENGTH = 2300


def read_files(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def restore_files(folder: Path, before: dict[str, bytes | None]) -> None:
    for path in sorted(folder.rglob("*"), reverse=True):
        if str(path.relative_to(folder)) not in before:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    for name, data in before.items():
        if data is not None:
            (folder / name).write_bytes(data)


def find_fault(code: int, message: str, changed: set[str]) -> str:
    """What is wrong with the end of a command; empty if nothing is."""
    if code not in (0, 2, 3):
        return f"exit {code}"
    if "Traceback" in message or "please report" in message:
        return "unexpected error"
    if code == 0:
        return ""
    while message.startswith("warning: "):
        _, _, message = message.partition("\n")
    if message.count("\n") != 1 or not message.startswith("fivtui: "):
        return "not one line"
    if not message.rstrip("\n").isprintable() or len(message) > MAX_MESSAGE_LENGTH:
        return "not printable, or too long"
    return f"left {sorted(changed)}" if changed else ""


@pytest.mark.parametrize("seed", range(4))
def test_a_random_command_line_exits_with_a_valid_status(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    work, scratch = tmp_path / "work", tmp_path / "scratch"
    work.mkdir()
    scratch.mkdir()
    create_files(work)
    monkeypatch.chdir(work)
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    before = read_files(tmp_path)
    faults, codes = [], []
    for command_line in lines(seed, 150):
        out, error = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            code = run(command_line)
        after = read_files(tmp_path)
        changed = {name for name in before | after if before.get(name) != after.get(name)}
        if problem := find_fault(code, error.getvalue(), changed):
            brief = " ".join(shlex.quote(argument[:60]) for argument in command_line)
            faults.append(f"{problem}: fivtui {brief}\n    {error.getvalue()[-300:]}")
        codes.append(code)
        if changed:
            restore_files(tmp_path, before)
    assert not faults, "\n".join(faults)
    # The sample contains both lines that run and lines that are refused.
    assert codes.count(0) > 2
    assert codes.count(2) > 50

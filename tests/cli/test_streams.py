"""Standard output that is full, closed, without a reader or in ASCII, and endless input files."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from fivtui.cli import run

ROOT = Path(__file__).parents[2]


def run_fivtui(*args: str, **options: Any) -> subprocess.CompletedProcess[bytes]:
    """Run the command in a process of its own; `options` are those of `subprocess.run`."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | options.pop("environment", {})
    return subprocess.run(
        [sys.executable, "-m", "fivtui", *args],
        env=environment,
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        timeout=600,
        check=False,
        **options,
    )


@pytest.mark.host
@pytest.mark.parametrize(
    ("args", "unbuffered"), [(["presets"], ""), (["presets", "--json"], "1"), (["--help"], "")]
)
def test_a_full_disk_under_standard_output_is_one_line_and_exit_3(
    args: list[str], unbuffered: str
) -> None:
    with Path("/dev/full").open("wb") as full:
        process = run_fivtui(*args, stdout=full, environment={"PYTHONUNBUFFERED": unbuffered})
    assert process.returncode == 3
    assert process.stderr.startswith(b"fivtui: standard output: cannot be written: No space left")
    assert process.stderr.count(b"\n") == 1


def test_non_ascii_characters_are_replaced_in_tables_and_escaped_in_json() -> None:
    ascii_only = {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    table = run_fivtui("stability", stdout=subprocess.PIPE, environment=ascii_only)
    assert (table.returncode, table.stderr) == (0, b"")
    assert "?" in table.stdout.decode("ascii")
    process = run_fivtui(
        "fmu", "check", "--json", "é.fmu", stdout=subprocess.PIPE, environment=ascii_only
    )
    assert process.returncode == 2
    assert process.stderr.decode("ascii") == "fivtui: \\xe9.fmu: there is no such file\n"
    data = run_fivtui("presets", "--json", stdout=subprocess.PIPE, environment=ascii_only)
    assert json.loads(data.stdout.decode("ascii"))["base"]["t_end"] == 100.0


def test_a_closed_pipe_or_standard_output_gives_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    process = run_fivtui("presets", stdout=writer)
    os.close(writer)
    assert (process.returncode, process.stderr) == (0, b"")
    closed = run_fivtui("presets", preexec_fn=lambda: os.close(1))
    assert (closed.returncode, closed.stderr) == (0, b"")


@pytest.mark.parametrize("name", ["/dev/zero", "pipe.toml", "folder"])
def test_special_files_are_refused_without_waiting(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    assert run(["stability", name]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"fivtui: {name}: ")
    assert captured.err.count("\n") == 1

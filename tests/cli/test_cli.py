"""The command line: its output, streams and exit status."""

import io
import json
import os
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from fivtui.cli import run

ROOT = Path(__file__).parents[2]


def run_fivtui(*args: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Output and exit status of a command, run in this process: a new one imports every module."""
    out, error = io.StringIO(), io.StringIO()
    with chdir(cwd or Path.cwd()), redirect_stdout(out), redirect_stderr(error):
        code = run(args)
    return subprocess.CompletedProcess(args, code, out.getvalue(), error.getvalue())


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["simulte"], "did you mean simulate?"),
        (["fmu", "biuld"], "did you mean build?"),
        (["simulate", "bse"], "did you mean base?"),
        (["simulate", "missing.toml"], "missing.toml"),
        (["simulate", "--set", "knl=3"], "did you mean k_nl?"),
        (["simulate", "--set", "t_end=60"], "is set by --t-end, here --t-end 60"),
        (["sweep", "--vary=F=1:2:2", "--set=tol=1e-6"], "is set by --tol, here --tol 1e-6"),
        (["simulate", "--set", "separation=ignored"], "is set by --ignore-separation\n"),
        (["simulate", "--set", "F"], "NAME=VALUE"),
        (["simulate", "--set", "F=heavy"], "F = 'heavy': not a number"),
        (["simulate", "--set", "m=0"], "m = 0: must be from 1e-12"),
        (["simulate", "--set", "k1=-1"], "k1 = -1: must be from 1e-12"),
        (["simulate", "--set", "mu=nan"], "not a finite number"),
        (["simulate", "--t-end", "-3"], "t_end"),
        (["simulate", "--t-end", "long"], "t_end = 'long': not a number"),
        (["simulate", "--tol", "0"], "must be from 1e-13 to 0.01"),
        (["simulate", "--method", "euler"], "known: taylor"),
        (["simulate", "--method", "taylor", "--step", "0.1"], "sets its step by tol"),
        (["simulate", "--start", "1,2,3"], "four"),
        (["simulate", "--start", "rest"], "static"),
        (["simulate", "--points", "1"], "2"),
        (["simulate", "--out", "run.txt"], ".csv"),
        (["simulate", "--plot", "run.bmp"], ".svg"),
        (["simulate", "--out", "none/run.csv"], "no folder"),
        (["simulate", "--out", "taken.csv"], "exists"),
        (["simulate", "--plot", "taken.png"], "exists"),
        (["simulate", "--colour"], "--colour"),
        (["stability", "--set", "c1=-0.1"], "c1 = -0.1: must be from 0"),
        (["compare"], "--out"),
        (["compare", "--out", "taken.csv"], "taken.csv"),
        (["fmu", "build"], "--out"),
        (["fmu", "build", "--out", "x.zip"], ".fmu"),
        (["fmu", "build", "--out", "taken.fmu"], "exists"),
        (["fmu", "check", "absent.fmu"], "absent.fmu"),
        (["fmu", "check", "taken.fmu"], "taken.fmu"),
        (["fmu", "run", "absent.fmu"], "absent.fmu"),
        ([], "the terminal laboratory needs a terminal"),
    ],
    ids=" ".join,
)
def test_wrong_input_prints_one_line_exits_with_2_and_leaves_no_files(
    args: list[str], message: str, tmp_path: Path
) -> None:
    for name in ("taken.csv", "taken.png", "taken.fmu"):
        (tmp_path / name).write_text("mine")
    process = run_fivtui(*args, cwd=tmp_path)
    assert process.returncode == 2, process.stderr
    assert process.stdout == ""
    assert message in process.stderr
    assert process.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "taken.csv",
        "taken.fmu",
        "taken.png",
    ]
    assert (tmp_path / "taken.csv").read_text() == "mine"


def test_a_failed_computation_reports_time_and_reason_and_exits_with_3() -> None:
    unbounded = ["--set", "k2=186", "--set", "k_nl=0", "--set", "mu=2", "--ignore-separation"]
    process = run_fivtui("simulate", "--t-end", "1e5", *unbounded)
    assert process.returncode == 3
    assert process.stdout == ""
    assert "at t = " in process.stderr
    assert "use separation, a cubic contact" in process.stderr
    assert process.stderr.count("\n") == 1


def test_an_unexpected_error_is_one_line_without_a_traceback() -> None:
    code = (
        "import fivtui.scene.presets, sys\n"
        "from fivtui.cli import main\n"
        "del fivtui.scene.presets.PRESETS\n"
        "main(['presets'])\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 3
    assert process.stderr.startswith("fivtui: unexpected ImportError")
    assert process.stderr.count("\n") == 1


def test_force_replaces_an_output(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("old")
    process = run_fivtui("simulate", "--t-end", "1", "--out", "run.csv", "--force", cwd=tmp_path)
    assert process.returncode == 0
    assert "old" not in (tmp_path / "run.csv").read_text()


def test_a_scene_file_can_be_simulated(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("fivtui_scene = 1\nt_end = 3.0\n[parameters]\nF = 33.0\n")
    process = run_fivtui("simulate", "mine.toml", "--set", "mu=0.1", "--json", cwd=tmp_path)
    data = json.loads(process.stdout)
    assert (data["t_end"], data["parameters"]["F"], data["parameters"]["mu"]) == (3.0, 33.0, 0.1)


def test_a_pipe_closed_by_its_reader_gives_no_traceback() -> None:
    command = f"{sys.executable} -m fivtui presets | head -n 1"
    process = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in process.stderr


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from fivtui.cli import run\n"
        "assert run(['--help']) == 0\n"
        "heavy = {'numpy', 'scipy', 'matplotlib', 'textual', 'rich', 'fmpy'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stderr.strip() == "[]"

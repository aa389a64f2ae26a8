"""The command ``fivtui sweep``: what it prints, writes and draws, and how it ends."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import click
import pytest
from matplotlib.figure import Figure

from fivtui.cli import commands, run
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.sweeps import parse_design
from fivtui.sweeps.charts import check_drawable
from fivtui.sweeps.design import DESIGN_KINDS, Design, DesignKind, Range
from fivtui.sweeps.report import SweepProgress, progress_text
from fivtui.sweeps.run import local_engine, sweep_in_memory
from fivtui.sweeps.study import Study

ROOT = Path(__file__).parents[2]
SHORT = ("--t-end=2", "--workers=1")


@pytest.fixture(autouse=True)
def _in_a_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def read_json(capsys: pytest.CaptureFixture[str]) -> Any:
    captured = capsys.readouterr()
    return json.loads(captured.out)


def test_rows_have_the_requested_errors(capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.toml").write_text("fivtui_scene = 1\naccuracy = {peak = 1e-3}\n")
    options = ["--error=half_range=1e-4", "--error=final=1e-5"]
    for args, columns in (
        (["scene.toml"], ["peak_error"]),
        (["scene.toml", "--tol=1e-6"], []),
        (["scene.toml", *options], ["half_range_error", "final_error"]),
    ):
        assert run(["sweep", *args, "--vary=F=60,80", "--output=y_abs", "--json", *SHORT]) == 0
        data = read_json(capsys)
        assert data["columns"] == ["F", "separation", "y_abs", *columns, "status", "reason"]
        assert all(0.0 <= error <= 1e-3 for row in data["rows"] for error in row[3:-2])


def test_the_options_reach_the_sweep(capsys: pytest.CaptureFixture[str]) -> None:
    args = "--vary F=60,80 --vary x0=0.1,0.2 --design list --set mu=0.5 --start 0,0,-1,0 --tol 1e-6"
    both = ["--both", "--output=x_end", "--output=stable", "--json"]
    assert run(["sweep", "coexistence", *args.split(), *both, "--t-end=1e-6"]) == 0
    data = read_json(capsys)
    assert data["columns"] == ["F", "x0", "separation", "x_end", "stable", "status", "reason"]
    assert [row[:3] for row in data["rows"]] == [
        [60.0, 0.1, True], [60.0, 0.1, False], [80.0, 0.2, True], [80.0, 0.2, False]
    ]  # fmt: skip
    assert [row[3] for row in data["rows"]] == pytest.approx([0.1, 0.1, 0.2, 0.2], abs=1e-9)
    assert [row[4] for row in data["rows"]] == [False] * 4


@pytest.mark.parametrize("design", ["random", "sobol"])
def test_sampled_designs_follow_their_seed(design: str, capsys: pytest.CaptureFixture[str]) -> None:
    args = ["sweep", "--vary=F=20:80", "--vary=k_nl=1:100:log", f"--design={design}", "--count=5"]
    rows = []
    for seed in ("0", "0", "1"):
        assert run([*args, f"--seed={seed}", "--output=stable", "--json"]) == 0
        rows.append(read_json(capsys)["rows"])
    assert rows[0] == rows[1] != rows[2]
    assert all(20.0 <= row[0] <= 80.0 and 1.0 <= row[1] <= 100.0 for row in rows[0])


def test_rows_are_printed_as_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["sweep", "--vary=F=20:80:3", *SHORT]) == 0
    shown = capsys.readouterr().out
    assert "y_half_range (m)" in shown
    assert "vx_max" not in shown
    assert run(["sweep", "--vary=F=20:80:100", "--output=vx_max", *SHORT]) == 0
    shown, message = capsys.readouterr()
    assert "vx_max (m/s)" in shown
    # A title, the names of the columns, and twice 20 rows.
    assert len(shown.splitlines()) == 2 + 20 + 20
    assert message == "only the first and last 20 rows are printed; --out and --json give all\n"


@pytest.mark.parametrize("name", ["out.csv", "out.parquet"])
def test_a_file_is_written_drawn_and_not_written_twice(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pyarrow")
    # The members are computed and stored in pieces of 3.
    args = ["sweep", "--vary=F=20:80:4", "--both", f"--out={name}", *SHORT]
    assert run([*args, "--piece=3", "--plot=a.png", "--json"]) == 0
    captured = capsys.readouterr()
    folder = Path.cwd()
    assert captured.err == f"wrote {name} in {folder}: 8 members\nwrote a.png in {folder}\n"
    assert len(json.loads(captured.out)["rows"]) == 8
    assert Path("a.png").read_bytes()[:4] == b"\x89PNG"
    before = Path(name).stat()
    assert run(args) == 0
    assert capsys.readouterr().err == f"wrote {name} in {folder}: 8 members, complete before\n"
    assert Path(name).stat().st_mtime_ns == before.st_mtime_ns


@pytest.mark.parametrize(
    "args",
    [["--out=a.csv", "--plot=a.png"], ["--out=a.csv", "--json"], ["--plot=a.png"], ["--json"], []],
)
def test_a_sweep_too_large_for_memory_is_refused_before_it_begins(
    args: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_args: object, **_options: object) -> None:
        raise AssertionError("the sweep was begun")

    monkeypatch.setattr("fivtui.sweeps.sweep_to_file", refuse)
    monkeypatch.setattr("fivtui.sweeps.sweep_in_memory", refuse)
    assert run(["sweep", "--vary=F=1:2:1000001", *args]) == 2
    assert "1000001 members: must be at most 1000000" in capsys.readouterr().err
    # With one member less the sweep begins: `refuse` ends it by an error other than wrong input.
    assert run(["sweep", "--vary=F=1:2:1000000", *args]) not in (0, 2)
    assert "the sweep was begun" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ([], "--vary"),
        (["--vary=knl=1:2:3"], "did you mean k_nl"),
        (["--vary=F=1:2"], "START:STOP:COUNT"),
        (["--vary=F=1,a"], "F = 'a': not a number"),
        (["--vary=F=1:2:3", "--vary=F=3:4:5"], "given twice"),
        (["--vary=F=1:2:3", "--design=sobol", "--count=3"], "START:STOP"),
        (["--vary=F=1:2", "--design=sobol"], "count"),
        (["--vary=F=1:2:3", "--count=4"], "count and seed must not be given"),
        (["--vary=F=1:2:3", "--design=grid"], "grid"),
        (["--vary=F=1:2:3", "--both", "--ignore-separation"], "--both"),
        (["--vary=F=1:2:3", "--output=peak"], "unknown output"),
        (["--vary=F=1:2:3", "--tol=1"], "must be from 1e-13 to 0.01"),
        (["--vary=F=1:2:3", "--t-end=no"], "t_end = 'no'"),
        (["--vary=F=1:2:3", "--workers=0"], "workers = 0"),
        (["--vary=F=1:2:3", "--out=a.npz"], ".parquet"),
        (["--vary=F=1:2:3", "--out=taken.csv"], "exists already"),
        (["--vary=F=1:2:3", "--plot=taken.png"], "exists already"),
        (["--vary=F=1:2:2000000"], "--out"),
        (["--vary=F=1:2:2000000", "--out=a.csv", "--json"], "held in memory"),
        (["--vary=F=1:2:2", "--vary=mu=0:1:2", "--vary=m=1:2:2", "--plot=a.png"], "one name or"),
        (["rk4.toml", "--vary=F=1:2:3"], "must be taylor, fmu, fmu-native for a sweep"),
        (
            ["--vary=F=1:2:3", "--method=fmu", "--error=peak=1e-3"],
            "method = fmu: must be taylor for error targets",
        ),
        (
            ["accurate.toml", "--vary=F=1:2:3"],
            "must be one of final, peak, half_range; a sweep does",
        ),
        (
            ["--vary=F=1:2:3", "--error=peak=1e-3", "--tol=1e-6"],
            "--error: must be given without --tol",
        ),
        (["--vary=F=1:2:3", "--error=peak=2"], "must be above 0 and at most 1"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_input_gets_one_line_and_exit_2(
    args: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    files = {
        "taken.csv": "mine",
        "taken.png": "mine",
        "rk4.toml": 'fivtui_scene = 1\nmethod = "rk4"\n',
        "accurate.toml": "fivtui_scene = 1\naccuracy = {events = 1e-3}\n",
    }
    for name, text in files.items():
        Path(name).write_text(text)
    assert run(["sweep", *args]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == files


def test_ctrl_c_keeps_finished_members_and_prints_how_to_continue(tmp_path: Path) -> None:
    parts = tmp_path / "out.csv.parts"
    code = (
        "import signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from fivtui.cli import main\n"
        "main(['sweep', '--vary=F=10:120:100000', '--out=out.csv', '--piece=50'])\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        until = time.monotonic() + 600.0
        while not list(parts.glob("0*.csv")):
            assert process.poll() is None
            assert time.monotonic() < until
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=600.0)
    assert process.returncode == 130
    members = 50 * len(list(parts.glob("0*.csv")))
    assert message == (
        f"fivtui: cancelled: {members} of 100000 members are kept in out.csv.parts: "
        "the same command continues\n"
    )


def test_progress_shows_count_rate_and_time_left() -> None:
    assert progress_text(1000, 0.25, 0.0, 0.0) == "250 of 1000 members (25.0%)"
    assert progress_text(1000, 0.5, 0.25, 10.0) == "500 of 1000 members (50.0%), 25/s, 20 s left"
    assert progress_text(10**9, 0.1, 0.1, 3600.0).endswith("2.78e+04/s, 9.0 h left")


def test_without_a_terminal_progress_is_printed_as_occasional_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    with SweepProgress(1000) as progress:
        for second in range(65):
            clock[0] = 100.0 + second
            assert progress(0.5 + second * 0.001) is True
    # Members that an earlier run computed do not count towards the speed.
    assert capsys.readouterr().err.splitlines() == [
        "fivtui: 530 of 1000 members (53.0%), 1/s, 7.8 min left",
        "fivtui: 560 of 1000 members (56.0%), 1/s, 7.3 min left",
    ]


def test_the_choices_of_design_are_the_implemented_kinds() -> None:
    (option,) = [param for param in commands.commands["sweep"].params if param.name == "design"]
    assert isinstance(option.type, click.Choice)
    assert list(option.type.choices) == list(DESIGN_KINDS)


def test_a_design_is_read_from_text() -> None:
    design = parse_design(["F=10:20:3:log", "y0=-1,1"], "product")
    assert dict(design.axes) == {"F": Range(10.0, 20.0, 3, log=True), "y0": (-1.0, 1.0)}
    design = parse_design(["F=10:20:log"], "random", 4, 2)
    assert dict(design.axes) == {"F": Range(10.0, 20.0, None, log=True)}
    assert (design.count, design.seed) == (4, 2)


def draw_sweep(
    axes: dict[str, Any], kind: DesignKind = "product", count: int | None = None, **options: Any
) -> Figure:
    study = Study(Design(axes, kind, count), Parameters(), t_end=5.0, **options)
    return sweep_in_memory(study, local_engine(1)).figure()


def test_a_logarithmic_range_has_a_logarithmic_axis() -> None:
    (axes,) = draw_sweep({"F": Range(1.0, 9.0, 3, log=True)}, outputs=("P_max",)).axes
    assert axes.get_xscale() == "log"
    assert axes.get_ylabel() == "Greatest contact force (N)"


def test_a_map_of_failed_members_can_be_drawn() -> None:
    # F < 0 lifts the slider, and with k3 = 0 no spring holds it.
    figure = draw_sweep({"F": (-6.0, -5.0), "k3": (0.0,)}, outputs=("y_abs",))
    figure.canvas.draw()
    axes = dict.fromkeys(("F", "mu", "k1"), (1.0, 2.0))
    with pytest.raises(InputError, match="one name or two"):
        check_drawable(Study(Design(axes), Parameters()))

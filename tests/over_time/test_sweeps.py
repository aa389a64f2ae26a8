"""Sweeps of scenes whose preload or belt speed follows a table, and the sticks in them.

The laboratory is the program in the terminal; it shows the parts of a sweep as they are computed.
"""

import json
from pathlib import Path

import pytest

from fivtui import load_scene, simulate, sweep
from fivtui.cli import run
from fivtui.model import InputError
from fivtui.scene.presets import PRESETS
from fivtui.sweeps import local_engine, parse_design, scene_study, sweep_in_memory
from fivtui.sweeps.charts import sweep_chart
from fivtui.sweeps.files import read_sweep
from fivtui.tui.session import Session
from fivtui.tui.session.command_lines import study_command
from fivtui.tui.tabs.studies.sweep import SweepPane
from tests.support.laboratory import command_line

BRAKE_STOP = PRESETS["brake-stop"]
TABLES = {"F": [(0.0, 20.0), (4.0, 90.0)], "v_belt": [(0.0, 1.0), (6.0, 0.0)]}


def test_a_member_of_a_sweep_equals_a_single_run() -> None:
    outputs = ["y_abs", "P_max", "y_end", "separations", "sticks", "stick_time", "final_stick"]
    result = sweep(
        BRAKE_STOP.parameters,
        vary={"k1": [80.0, 120.0], "vx0": [0.0, 1.0]},
        over_time=TABLES,
        t_end=8.0,
        outputs=outputs,
        separation="both",
    )
    assert len(result.rows) == 8
    for k1, vx, separation, *values, status, _ in result.rows:
        p = BRAKE_STOP.parameters.with_values({"k1": k1})
        # Components of the start that do not vary are those of the equilibrium at t = 0.
        x, _, y, _ = simulate(p, t_end=1.0, over_time=TABLES, separation=separation).start
        run = simulate(p, t_end=8.0, over_time=TABLES, separation=separation, start=(x, vx, y, 0.0))
        events = run.events
        assert status == "done"
        assert run.final_stick is not None
        assert values == [
            run.peak.y_abs,
            run.contact_force.max,
            run.final.y,
            events.separations,
            events.sticks,
            events.stick_time,
            run.final_stick,
        ]


def test_a_brake_stop_is_swept_into_a_file_that_stores_its_tables(tmp_path: Path) -> None:
    out, plot = tmp_path / "stops.csv", tmp_path / "stops.png"
    arguments = ["sweep", "brake-stop", "--vary", "c1=0.3,0.6", "--output", "final_stick"]
    assert run([*arguments, "--output", "y_abs", "--out", str(out), "--plot", str(plot)]) == 0
    header = next(line for line in out.read_text().splitlines() if line.startswith("# sweep: "))
    tables = {name: [list(row) for row in table.rows()] for name, table in BRAKE_STOP.over_time}
    assert json.loads(header.removeprefix("# sweep: "))["over_time"] == tables
    restored = read_sweep(out)
    assert restored.study.over_time == BRAKE_STOP.over_time
    stops = [
        simulate(BRAKE_STOP.parameters.with_values({"c1": c1}), t_end=40.0, over_time=tables)
        for c1 in (0.3, 0.6)
    ]
    for (_c1, _separation, final_stick, *_), stop in zip(restored.rows, stops, strict=True):
        assert final_stick == stop.final_stick
    # An origin is a scene, here with the preset that names it on the command line.
    assert study_command("sweep", restored.study, Session(BRAKE_STOP, "brake-stop")) == (
        "fivtui sweep brake-stop --vary c1=0.3,0.6 --output final_stick --output y_abs"
    )
    with pytest.raises(InputError, match="no option sets over_time; save the scene"):
        study_command("sweep", restored.study, Session())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "F=20,30"], "F: follows a table over time; must not be varied"),
        (["--vary", "k1=80", "--output", "stable"], "output stable: must be left out, as F, "),
        (["--vary", "k1=80", "--error", "peak=1e-3"], "F, v_belt over time: must be constant for"),
        (["--vary", "k1=80", "--method", "fmu"], "the method must be taylor or fmu-native"),
    ],
)
def test_options_without_support_of_tables_are_refused(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["sweep", "brake-stop", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_table_of_a_file_is_swept_as_in_simulate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ramp.csv").write_text("time,F\n0,20\n4,90\n")
    arguments = ["--over-time", str(tmp_path / "ramp.csv"), "--t-end", "5", "--json"]
    assert run(["sweep", "--vary", "k1=80", "--output", "y_abs", *arguments]) == 0
    ((_k1, _separation, y_abs, *_),) = json.loads(capsys.readouterr().out)["rows"]
    assert run(["simulate", "--set", "k1=80", *arguments]) == 0
    assert y_abs == json.loads(capsys.readouterr().out)["peak"]["y_abs"]


def test_the_laboratory_sweeps_a_brake_stop() -> None:
    study = SweepPane.parse(BRAKE_STOP, "c1=0.3,0.6")
    result = sweep_in_memory(study, local_engine(1))
    assert result.table.failed == 0
    # Peak and half peak-to-peak of y, each with separation considered and ignored.
    assert len(sweep_chart(result).traces) == 4


def test_command_lines_reproduce_scenes_with_tables_or_are_refused() -> None:
    session = Session(BRAKE_STOP, "brake-stop")
    session.set_text("k1", "120")
    assert command_line(session) == "fivtui simulate brake-stop --set k1=120"
    # Stability is evaluated at t = 0.
    line = study_command("stability", session.stability(), session)
    assert line.startswith("fivtui stability --set")
    assert "--set F=10" in line
    with pytest.raises(InputError, match="no option sets over_time; save the scene"):
        command_line(Session(BRAKE_STOP))


def test_sticks_are_outputs_of_sweeps_without_tables() -> None:
    study = scene_study(
        PRESETS["base"], parse_design(["v_belt=0,1"], "product"), outputs=["sticks"]
    )
    # Members are single runs: batches do not count sticks.
    assert study.is_run_by_run
    result = sweep(vary={"v_belt": [0.0, 1.0]}, t_end=10.0, outputs=["sticks", "final_stick"])
    runs = [simulate(study.parameters.with_values({"v_belt": v}), t_end=10.0) for v in (0.0, 1.0)]
    for (_v_belt, _separation, sticks, final_stick, *_), single_run in zip(
        result.rows, runs, strict=True
    ):
        assert (sticks, final_stick) == (single_run.events.sticks, single_run.final_stick)
    # Error targets (`accuracy`) refine the tolerance of batches.
    with pytest.raises(InputError, match="output sticks: must be without error targets"):
        sweep(vary={"v_belt": [1.0]}, outputs=["sticks"], accuracy={"peak": 1e-3})


def test_a_scene_file_may_omit_the_first_value_of_its_table(tmp_path: Path) -> None:
    text = "fivtui_scene = 1\n[parameters]\nmu_s = 0.4\n[over_time]\nmu = [[0, 0.2], [4, 0.3]]\n"
    (tmp_path / "s.toml").write_text(text)
    assert load_scene(tmp_path / "s.toml").parameters.mu == 0.2
    (tmp_path / "s.toml").write_text(text.replace("0.3]", "0.5]"))
    with pytest.raises(InputError, match=r"reaches 0\.5: must be at most mu_s = 0\.4"):
        load_scene(tmp_path / "s.toml")


def test_a_scene_file_must_not_contradict_the_first_value_of_its_table(tmp_path: Path) -> None:
    text = "fivtui_scene = 1\n[parameters]\nF = 80\n[over_time]\nF = [[0, 10], [4, 60]]\n"
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match="F = 80: follows a table over time, which begins with 10"):
        load_scene(tmp_path / "s.toml")
    (tmp_path / "s.toml").write_text(text.replace("80", "10"))
    assert load_scene(tmp_path / "s.toml").parameters.F == 10.0


def test_measured_data_are_laid_over_a_run_with_the_measured_preload(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ramp.csv").write_text("time,F\n0,20\n4,90\n")
    options = ["--over-time", str(tmp_path / "ramp.csv"), "--t-end", "6"]
    assert run(["simulate", *options, "--out", str(tmp_path / "run.csv")]) == 0
    measured_options = [
        "--measured",
        str(tmp_path / "run.csv"),
        "--time",
        "t",
        "--signal",
        "y",
        "--json",
    ]
    deviations = []
    for over_time in (options, options[2:]):
        capsys.readouterr()
        run(["validate", *over_time, *measured_options])
        deviations.append(json.loads(capsys.readouterr().out)["deviation"]["rms"])
    assert deviations[0] < 1e-9 < 1e-2 < deviations[1]

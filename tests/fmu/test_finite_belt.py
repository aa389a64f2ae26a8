"""Runs of the FMU on a belt of finite speed agree with direct runs: `simulate` without an FMU."""

import json
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.cli import run
from fivtui.fmu.run import run_fmu
from fivtui.fmu.transient import integrate_fmu
from fivtui.model import ComputationError, InputError, Mode, System, time_tables
from fivtui.transient import Request, Transient

METHODS = ["fmu", "fmu-native"]
# v_belt and v_s in m/s: the slider sticks, slides and separates.
P = Parameters(v_belt=2.0, mu_s=0.8, v_s=0.4)
# x (m), vx (m/s), y (m), vy (m/s).
START = (2.0, 8.0, 1.0, 0.0)
SETTING_ARGUMENTS = ["--set", "v_belt=2", "--set", "mu_s=0.8", "--set", "v_s=0.4"]


def assert_same(fmu_run: Transient, direct_run: Transient) -> None:
    assert fmu_run.final == pytest.approx(direct_run.final, rel=1e-12, abs=1e-12)
    assert fmu_run.peak == pytest.approx(direct_run.peak, rel=1e-8, abs=1e-8)
    assert fmu_run.changes == pytest.approx(direct_run.changes, abs=1e-12)
    for actual, expected in zip(
        fmu_run.separated_intervals, direct_run.separated_intervals, strict=True
    ):
        assert actual == pytest.approx(expected, abs=1e-12)
    assert fmu_run.events.transitions == direct_run.events.transitions
    assert fmu_run.events.sticks == direct_run.events.sticks
    assert fmu_run.events.stick_time == pytest.approx(direct_run.events.stick_time, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("step", [None, 0.01, 5.0])
def test_any_communication_step_gives_the_result_of_a_direct_run(
    method: str, step: float | None
) -> None:
    fmu_run = simulate(P, t_end=5.0, start=START, method=method, step=step)
    direct_run = simulate(P, t_end=5.0, start=START)
    assert_same(fmu_run, direct_run)
    assert direct_run.events.sticks > 2
    assert direct_run.events.separations > 0


@pytest.mark.parametrize("method", METHODS)
def test_the_commands_simulate_and_sweep_run_the_fmu(
    method: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    direct_run = simulate(P, t_end=3.0)
    assert run(["simulate", *SETTING_ARGUMENTS, "--t-end", "3", "--method", method, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["events"]["sticks"] == direct_run.events.sticks > 0
    assert summary["events"]["transitions"] == dict(direct_run.events.transitions)
    out = f"{tmp_path}/rows.csv"
    arguments = ["sweep", "--vary", "v_belt=1:2:2", *SETTING_ARGUMENTS[2:], "--t-end", "3"]
    assert run([*arguments, "--method", method, "--json", "--out", out]) == 0
    table = json.loads(capsys.readouterr().out)
    column = table["columns"].index("y_abs")
    peaks = [simulate(P.with_values({"v_belt": v}), t_end=3.0).peak.y_abs for v in (1, 2)]
    assert [row[column] for row in table["rows"]] == pytest.approx(peaks, rel=1e-8)


# Points (time in s, value) of each input; a repeated time is a jump.
TABLES: Final[dict[str, list[tuple[float, float]]]] = {
    "F": [(0, 40), (4, 100), (8, 60)],
    "mu": [(0, 0.7), (2, 0.7), (6, 0.5), (6, 0.8)],
    "v_belt": [(0, 3), (1, 3), (5, 1), (5, 2), (9, 0)],
}


@pytest.mark.parametrize("step", [None, 0.37])
@pytest.mark.parametrize("belt", [{}, {"mu_s": 0.9, "v_s": 0.4}])
def test_tables_over_time_give_the_motion_of_a_direct_run(
    step: float | None, belt: dict[str, float]
) -> None:
    options: dict[str, Any] = {"t_end": 10.0, "over_time": TABLES, "samples": 101}
    fmu_run = simulate(Parameters(**belt), method="fmu-native", step=step, **options)
    direct_run = simulate(Parameters(**belt), **options)
    assert_same(fmu_run, direct_run)
    # Times of squeal, groan and final stick as the belt slows down.
    assert fmu_run.stop == pytest.approx(direct_run.stop, abs=1e-12)
    actual, expected = fmu_run.trajectory, direct_run.trajectory
    assert actual is not None
    assert expected is not None
    assert actual.x == pytest.approx(expected.x, abs=1e-12)
    assert np.array_equal(actual.mode, expected.mode)


def test_a_sticking_slider_starts_to_slide_when_the_belt_speed_jumps() -> None:
    p = Parameters(v_belt=1.0, mu_s=0.9)
    begin, end = simulate(p, t_end=4.0).stick_intervals[1]
    jump = 0.5 * (begin + end)
    tables = {"v_belt": [(0.0, 1.0), (jump, 1.0), (jump, 2.0)], "F": [(jump, 80.0), (4.0, 60.0)]}
    fmu_run = simulate(p, t_end=4.0, over_time=tables, method="fmu-native")
    direct_run = simulate(p, t_end=4.0, over_time=tables)
    assert_same(fmu_run, direct_run)
    assert (jump, Mode.STICK, Mode.FORWARD) in fmu_run.mode_changes


def test_tables_over_time_need_derivatives_of_inputs(fmu: Path) -> None:
    system = System(Parameters(), over_time=time_tables(TABLES))
    request = Request(system, t_end=1.0, method="fmu-native")
    with pytest.raises(
        InputError, match=r"F, mu, v_belt over time: .* does not accept derivatives"
    ):
        integrate_fmu(request, fmu=fmu)


def test_a_start_value_of_v_belt_selects_a_finite_belt(
    fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    direct_run = simulate(P, t_end=3.0)
    assert run(["fmu", "run", str(fmu), *SETTING_ARGUMENTS, "--t-end", "3", "--json"]) == 0
    final = json.loads(capsys.readouterr().out)["final"]
    assert final["y"] == pytest.approx(direct_run.final.y, rel=1e-12)
    assert final["sticks"] == direct_run.events.sticks
    table = tmp_path / "speed.csv"
    table.write_text("time,v_belt\n0,2\n3,2\n")
    friction = {"mu_s": 0.8, "v_s": 0.4}
    result = run_fmu(fmu, t_end=3.0, start_values=friction, input_csv=table)
    assert result.columns["y"][-1] == pytest.approx(direct_run.final.y, rel=1e-12)
    # Without a finite belt, the slider never sticks.
    y_without_belt = simulate(t_end=3.0).final.y
    result_without_belt = run_fmu(fmu, t_end=3.0)
    assert result_without_belt.columns["y"][-1] == pytest.approx(y_without_belt, rel=1e-12)
    with pytest.raises(ComputationError, match="v_belt = 2: has no effect without finite_belt"):
        run_fmu(fmu, t_end=3.0, start_values={"v_belt": 2.0, "finite_belt": False})

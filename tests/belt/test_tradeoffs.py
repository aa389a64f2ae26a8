"""RK4 across the switches, and errors against CPU time, on a belt of finite speed."""

from pathlib import Path

import numpy as np
import pytest

from fivtui import Parameters, accuracy, simulate
from fivtui.assessment.report import print_accuracy
from fivtui.model import State, time_scale
from fivtui.scene import Scene
from fivtui.tradeoffs import measure
from fivtui.tradeoffs.files import load_tradeoff, save_tradeoff
from fivtui.tradeoffs.measure import measure_tradeoff
from fivtui.tradeoffs.report import print_tradeoff, settings_table
from fivtui.transient import Start, Transient

BELT = Parameters(v_belt=1.0)
WITH_STICKS = Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4)
START_AT_BELT_SPEED: State = (0.0, 0.5, -1.0, 0.0)


def run_rk4_across(p: Parameters, step: float, *, start: Start = "static") -> Transient:
    return simulate(p, t_end=1.5, method="rk4-across", step=step, start=start)


def test_rk4_across_has_no_sticks_and_converges_at_first_order_at_most() -> None:
    exact = simulate(WITH_STICKS, t_end=1.5, start=START_AT_BELT_SPEED)
    assert exact.events.sticks > 0
    steps = [8e-3, 4e-3, 2e-3, 1e-3]
    runs = [run_rk4_across(WITH_STICKS, step, start=START_AT_BELT_SPEED) for step in steps]
    errors = [np.abs(np.subtract(run.final, exact.final)).max() for run in runs]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.5 < order < 1.6
    assert {run.events.sticks for run in runs} == {0}
    assert runs[-1].events.transitions["forward-backward"] > 10


def test_rk4_across_has_no_friction_at_the_speed_of_the_belt() -> None:
    # Slider and belt are at rest; friction of either sign would move the slider.
    rest = Parameters(v_belt=0.0)
    exact = simulate(rest, t_end=1.5)
    assert run_rk4_across(rest, 2e-3).final == pytest.approx(exact.final, abs=1e-6)
    assert (
        run_rk4_across(Parameters(v_belt=40.0), 2e-3).final
        == run_rk4_across(Parameters(), 2e-3).final
    )


@pytest.mark.parametrize(
    ("values", "start", "t_end"),
    [
        ({"v_belt": 1.0}, "static", 20.0),
        ({"v_belt": 0.5, "mu_s": 0.9, "v_s": 0.4}, (-2.0, -4.0, -1.0, 3.0), 8.0),
        ({"v_belt": 0.3, "mu": 0.2, "k3": 0.0}, (1.5, 5.0, -1.0, 4.0), 8.0),
    ],
)
def test_a_small_error_grows_like_the_distance_of_neighbouring_motions(
    values: dict[str, float], start: Start, t_end: float, capsys: pytest.CaptureFixture[str]
) -> None:
    p = Parameters().with_values(values)
    result = accuracy(p, t_end=t_end, start=start)
    # Velocities times this scale are comparable with displacements.
    time = time_scale(p)
    weights = np.array([1.0, time, 1.0, time])
    # A deviation of length 1 in these weights.
    unit_deviation = 0.5 / weights
    middle, final_states = np.array(result.run.start), []
    for size in (-1e-6, 1e-6):
        neighbour = (middle + size * unit_deviation).tolist()
        final_states.append(
            np.array(simulate(p, t_end=t_end, start=neighbour, tol=1e-13).final[1:])
        )
    growth = np.linalg.norm((final_states[1] - final_states[0]) / 2e-6 * weights)
    assert result.growth.final == pytest.approx(growth, rel=1e-5)
    assert result.run.events.sticks > 1
    # The run and its finer check do not diverge.
    assert result.parted is None
    assert result.estimates["sticks"].difference == 0.0
    for name in ("x", "vx", "y", "vy", "stick_time"):
        assert result.estimates[name].difference < 1e-9
    print_accuracy(result)
    assert "stick_time" in capsys.readouterr().out


def test_a_tradeoff_on_a_belt_of_finite_speed_has_the_errors_of_every_method(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # CPU time of a measurement that is not thorough, s.
    monkeypatch.setattr(measure, "QUICK_S", 1.0)
    result = measure_tradeoff(Scene("belt", "", BELT, t_end=4.0))
    # The floor is the uncertainty of the run that errors are measured against.
    assert result.floor.of("final") < 1e-10
    least_errors: dict[str, float] = {}
    for row in result.rows:
        if row.error is not None:
            method, error = row.setting.method, row.error.of("final")
            least_errors[method] = min(error, least_errors.get(method, np.inf))
    assert least_errors["taylor"] < 1e-10
    assert least_errors["fmu"] < 1e-10
    assert least_errors["rk4"] < 0.1
    assert 1e-4 < least_errors["rk4-across"] < 10.0
    fmu = [row for row in result.rows if row.setting.method == "fmu" and row.error is not None]
    assert fmu[-1].error is not None
    assert fmu[-1].error.of("events") < 1e-10
    assert fmu[-1].error.sticks == 0
    # RK4 across the switches misses every stick.
    stick_error = -simulate(BELT, t_end=4.0).events.sticks
    assert {
        row.error.sticks for row in result.rows if row.setting.method == "rk4-across" and row.error
    } == {stick_error}
    print_tradeoff(result)
    assert "sticks" in capsys.readouterr().out
    columns, rows = settings_table(result)
    sticks = columns.index("sticks")
    assert {row[sticks] for row in rows} >= {"+0", f"{stick_error:+d}"}
    save_tradeoff(result, tmp_path / "trade.csv")
    loaded_rows = load_tradeoff(tmp_path / "trade.csv").rows
    assert [row.error and row.error.sticks for row in loaded_rows] == [
        row.error and row.error.sticks for row in result.rows
    ]
    assert "belt of finite speed" in [feature.name for feature in result.features]

"""The FMU, run by fmpy without the project installed, gives the results of direct runs.

A direct run is one of `simulate` without an FMU. A call of the driver is an instance, by a name, a
method of `tests/support/fmu_driver.py`, and its arguments.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fivtui import Parameters, simulate
from fivtui.model.slider_belt import State
from tests.support.fmu_driver import Call, Driver
from tests.support.fmu_tools import simulate_interpreted

STATES = ["x", "vx", "y", "vy"]


@pytest.fixture(scope="module")
def driver(fmu: Path) -> Iterator[Driver]:
    with Driver(fmu) as driver:
        yield driver


def final_state(**options: Any) -> State:
    """Final state of a direct run, by the interpreted kernel unless a method is named."""
    final = (simulate if "method" in options else simulate_interpreted)(**options).final
    return (final.x, final.vx, final.y, final.vy)


@pytest.mark.parametrize("separation", [True, False])
@pytest.mark.parametrize("t_end", [4.0, pytest.param(6.0, marks=pytest.mark.whole)])
def test_the_independent_rk4_converges_to_the_fmu_in_fourth_order(
    driver: Driver, t_end: float, separation: bool
) -> None:
    run = {"stop_time": t_end, "start_values": {"separation": separation}, "output_interval": 0.5}
    (end,) = driver.simulate(run)
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        rk4 = final_state(t_end=t_end, separation=separation, method="rk4", step=step)
        errors.append(max(abs(end[name] - x) for name, x in zip(STATES, rk4, strict=True)))
    # Half the step divides an error of fourth order by about 16.
    assert errors[2] < 1e-7
    assert errors[0] > 12.0 * errors[1] > 144.0 * errors[2]


def test_a_tolerance_of_the_experiment_gives_the_direct_run_with_that_tolerance(
    driver: Driver,
) -> None:
    runs = [{"stop_time": 20.0, "relative_tolerance": tol} for tol in (1e-4, 1e-8, 1e-13)]
    for run, end in zip(runs, driver.simulate(*runs), strict=True):
        tol = run["relative_tolerance"]
        assert tuple(end[name] for name in STATES) == final_state(t_end=20.0, tol=tol)


def test_parameters_and_start_values_reach_the_model(driver: Driver) -> None:
    values = {"m": 2.0, "k1": 80.0, "k2": 70.0, "k3": 30.0, "c1": 0.5, "c2": 0.1, "k_nl": 250.0}
    start = (0.1, -0.2, -0.3, 0.4)
    settings = {f"{name}_start": x for name, x in zip(STATES, start, strict=True)}
    run = {
        "stop_time": 10.0,
        "start_values": {**values, "F": 50.0, "mu": 0.9, "start_static": False, **settings},
    }
    (end,) = driver.simulate(run)
    p = Parameters(**values, F=50.0, mu=0.9)
    assert tuple(end[name] for name in STATES) == final_state(parameters=p, start=start, t_end=10.0)


def test_inputs_changed_at_communication_points_give_the_piecewise_direct_run(
    driver: Driver,
) -> None:
    # Preload (N) and friction coefficient of each piece, which lasts 2.5 s.
    pieces = [(80.0, 0.7), (120.0, 0.7), (0.0, 1.1), (-20.0, 0.2), (60.0, 0.9)]
    calls: list[Call] = [("a", "begin")]
    for number, (F, mu) in enumerate(pieces):
        calls += [("a", "set", {"F": F, "mu": mu}), ("a", "steps", 2.5 * number, 0.1, 25)]
    calls.append(("a", "get", [*STATES, "separations"]))
    *state, separations = driver.drive(*calls)[-1].value
    direct_run = simulate_interpreted(Parameters(F=80.0, mu=0.7), t_end=2.5)
    switches = direct_run.events.separations
    for F, mu in pieces[1:]:
        end = direct_run.final
        start = (end.x, end.vx, end.y, end.vy)
        direct_run = simulate_interpreted(Parameters(F=F, mu=mu), t_end=2.5, start=start)
        switches += direct_run.events.separations
    assert separations == switches > 0
    end = direct_run.final
    assert state == pytest.approx([end.x, end.vx, end.y, end.vy], rel=1e-10, abs=1e-10)


def test_forces_follow_from_the_state_and_the_present_friction(driver: Driver) -> None:
    names = ["y", "P", "friction_slider", "friction_belt", "mode", "switching"]
    calls: list[Call] = [("a", "begin")]
    for number in range(60):
        calls += [("a", "step", 0.1 * number, 0.1), ("a", "get", names)]
    calls += [("a", "set", {"mu": 2.0}), ("a", "get", names)]
    modes = set()
    answers = zip(calls, driver.drive(*calls), strict=True)
    *before, after = [answer.value for call, answer in answers if call[1] == "get"]
    for y, P, friction_on_slider, friction_on_belt, mode, switching in before:
        # Contact force with k2 = 50 N/m and k_nl = 100 N/m³.
        assert pytest.approx(-50.0 * y - 100.0 * y**3 if y < 0.0 else 0.0) == P
        assert (friction_on_slider, friction_on_belt) == (0.7 * P, -0.7 * P)
        assert mode == (y < 0.0)
        assert switching == y
        modes.add(mode)
    assert modes == {0.0, 1.0}
    assert after[2] == 2.0 * after[1]


def test_a_run_may_start_at_any_time(driver: Driver) -> None:
    runs = [{"start_time": 1000.0, "stop_time": 1020.0, "output_interval": 0.5}]
    (end,) = driver.simulate(*runs)
    direct_run = simulate_interpreted(t_end=20.0)
    assert [end[name] for name in STATES] == pytest.approx(list(final_state(t_end=20.0)), rel=1e-9)
    assert end["last_event"] == pytest.approx(1000.0 + (direct_run.events.last or 0.0))

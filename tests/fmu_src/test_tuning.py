"""Parameters and inputs that change during a run of the FMU: tuning, a belt that runs backward."""

from typing import Any, Final

import pytest

from fivtui import Parameters, simulate
from fivtui.transient import Transient
from fmu_src.build.builder import PYTHON
from tests.support.fmu_driver import Call, Driver

STATES: Final = ["x", "vx", "y", "vy"]
READ: Final = [*STATES, "P_max", "y_peak", "separated_time"]
# A time inside an integrator step, off the belt, s; the end.
T_CHANGE, T_END = 3.3, 7.3
TUNED: Final[dict[str, float]] = {
    "k1": 150.0,
    "k2": 70.0,
    "k3": 40.0,
    "c1": 0.1,
    "c2": 0.6,
    "k_nl": 300.0,
}


def final_state(run: Transient) -> list[float]:
    return [run.final.x, run.final.vx, run.final.y, run.final.vy]


@pytest.mark.parametrize("values", [TUNED, {"k_nl": 0.0}])
def test_tuned_parameters_continue_the_motion_from_its_state(
    driver: Driver, flavour: str, values: dict[str, float]
) -> None:
    first = simulate(t_end=T_CHANGE)
    second = simulate(Parameters(**values), t_end=T_END - T_CHANGE, start=final_state(first))
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "steps", 0.0, 0.1, 33),
        ("a", "set", values),
        ("a", "steps", T_CHANGE, 0.5, 8),
        ("a", "get", READ),
    ]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    runs = first, second
    expected = [
        *final_state(second),
        max(run.contact_force.max for run in runs),
        max(run.peak.y_abs for run in runs),
        sum(run.events.separated_time for run in runs),
    ]
    # Only rounding differs: the time of a run is not zero where it continues.
    assert answers[-1].value == pytest.approx(expected, rel=1e-9), flavour


def test_forces_follow_a_tuned_stiffness_at_once_and_a_state_keeps_it(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "step", 0.0, 0.9),
        ("a", "get", ["y", "P", "P_max"]),
        ("a", "set", {"k2": 500.0}),
        ("a", "get", ["y", "P", "P_max"]),
        # The saved motion has the stiffness before, its values have the one after.
        ("a", "save", "saved"),
        ("a", "serialize", "saved", "copy"),
        ("a", "step", 0.9, 1.0),
        ("a", "get", READ),
        ("b", "begin"),
        ("b", "restore", "copy"),
        ("b", "step", 0.9, 1.0),
        ("b", "get", READ),
        ("a", "forget", "saved"),
        ("b", "forget", "copy"),
    ]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    before, after, end, restored_end = (a.value for a in answers if isinstance(a.value, list))
    y, P, _ = before
    assert after[:2] == pytest.approx([y, P - (500.0 - 50.0) * y])
    assert after[2] == after[1] > before[2]
    assert restored_end == end


def test_a_belt_that_runs_backward_follows_its_table(driver: Driver) -> None:
    speeds = [(0.0, -1.5), (3.0, 2.0), (5.0, -0.5)]
    jumps = [(0.0, -1.5), (3.0, -1.5), (3.0, 2.0), (5.0, 2.0), (5.0, -0.5)]
    p = Parameters(mu_s=0.9, v_s=0.4)
    run = simulate(p, t_end=10.0, over_time={"v_belt": jumps})
    calls: list[Call] = [
        ("a", "begin", {"finite_belt": True, "v_belt": -1.5, "mu_s": 0.9, "v_s": 0.4})
    ]
    for (t, speed), end in zip(speeds, (3.0, 5.0, 10.0), strict=True):
        calls += [("a", "set", {"v_belt": speed}), ("a", "step", t, end - t)]
    answers = driver.drive(*calls, ("a", "get", [*STATES, "sticks", "vx_max"]))
    assert {answer.status for answer in answers} == {"ok"}
    expected = [*final_state(run), run.events.sticks, run.peak.vx_max]
    assert answers[-1].value == pytest.approx(expected, rel=1e-9)
    # The slider sticks to the belt in both directions.
    kinds = run.events.transitions
    assert kinds["stick-forward"] > 0
    assert kinds["stick-backward"] > 0


@pytest.mark.parametrize("finite", [False, True])
@pytest.mark.parametrize("speed", [2.0, -1.0])
def test_a_belt_speed_without_effect_is_refused(
    driver: Driver, flavour: str, speed: float, finite: bool
) -> None:
    start: dict[str, Any] = {"v_belt": speed, "finite_belt": finite}
    message = f"v_belt = {speed:g}: has no effect without finite_belt, which must be set"
    begin, step = driver.drive(("a", "begin", start), ("a", "step", 0.0, 0.1))
    assert any(message in line for line in begin.log) is not finite
    assert (step.status == "ok") is finite
    calls: list[Call] = [
        ("a", "begin", {"finite_belt": finite}),
        ("a", "step", 0.0, 0.1),
        ("a", "set", {"v_belt": speed}),
        ("a", "step", 0.1, 0.1),
        ("a", "step", 0.1, 0.1),
    ]
    _, _, change, *steps = driver.drive(*calls)
    assert any(message in line for line in change.log) is not finite
    if not finite:
        # The Python flavour discards the step after a refused call; the native one goes on.
        discarded = 0 if flavour == PYTHON else 1
        assert steps[discarded].status == "discard"
        assert steps[1 - discarded].status == "ok"

"""Refused calls are logged, change nothing, and make the next step fail."""

import math
from typing import Any

import pytest

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.taylor import overflow_error
from fivtui.transient import KernelChoice
from fmu_src.build.builder import NATIVE, PYTHON
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_driver import Answer, Call, Driver

STATES = ["x", "vx", "y", "vy"]
KERNELS: dict[str, KernelChoice] = {PYTHON: "interpreted", NATIVE: "compiled"}
# Value references of the variables.
X, F, SEPARATION = (REFERENCES[name] for name in ("x", "F", "separation"))


def final_state(flavour: str, t_end: float) -> list[float]:
    """Final state of a native run by the kernel that the FMU flavour uses."""
    kernel = KERNELS[flavour]
    final = simulate(t_end=t_end, kernel=kernel).final
    return [final.x, final.vx, final.y, final.vy]


@pytest.mark.parametrize(
    ("step", "message"),
    [
        ((1.0, 0.0), "step size = 0.0"),
        ((1.0, -0.5), "step size = -0.5"),
        ((1.0, float("nan")), "step size = nan"),
        ((1.0, float("inf")), "step size = inf"),
        ((1.0, 1e-300), "step size = 1e-300"),
        ((0.5, 0.5), "the FMU is at 1.0 s"),
        ((2.0, 0.5), "the FMU is at 1.0 s"),
        ((float("nan"), 0.5), "current time = nan"),
    ],
)
def test_an_invalid_step_is_refused_and_the_run_can_continue(
    driver: Driver, flavour: str, step: tuple[float, float], message: str
) -> None:
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "step", 0.0, 1.0),
        ("a", "get", STATES),
        ("a", "step", *step),
        ("a", "get", STATES),
        ("a", "step", 1.0, 1.0),
        ("a", "get", STATES),
    ]
    _, _, state_before, refused_step, state_after, _, final_answer = driver.drive(*calls)
    assert refused_step.status == "discard"
    assert len(refused_step.log) == 1
    assert message in refused_step.log[0]
    assert "\n" not in refused_step.log[0]
    assert state_before.value == state_after.value
    assert final_answer.value == final_state(flavour, 2.0)


@pytest.mark.parametrize(
    ("kind", "reference", "value", "message"),
    [
        ("Real", F, float("nan"), "F = nan: not a finite number"),
        ("Real", F, float("inf"), "F = inf"),
        ("Real", F, 1e10, "F = 1e+10: must be from -1e+09 to 1e+09 N"),
        ("Real", REFERENCES["mu"], -0.1, "mu = -0.1: must be from 0 to 100"),
        ("Real", REFERENCES["m"], 6.0, "m cannot be set while stepping"),
        ("Real", REFERENCES["x_start"], 6.0, "x_start cannot be set while stepping"),
        ("Boolean", SEPARATION, False, "separation cannot be set while stepping"),
        ("Real", X, 0.0, "x is an output"),
        ("Real", SEPARATION, 1.0, "separation is of type Boolean, not Real"),
        ("Integer", F, 90, "F is of type Real, not Integer"),
        ("Real", len(VARIABLES), 1.0, "value reference"),
        ("Real", 2**32 - 1, 1.0, "value reference"),
        ("String", F, "90", "no variable is of type String"),
    ],
)
def test_an_invalid_value_is_refused_and_changes_nothing(
    driver: Driver, flavour: str, kind: str, reference: int, value: Any, message: str
) -> None:
    # The Python wrapper cannot refuse a call: only the next step reports the error.
    steps = [("a", "step", 1.0, 1.0)] * (2 if flavour == PYTHON else 1)
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "step", 0.0, 1.0),
        ("a", "set_raw", kind, [reference], [value]),
        *steps,
        ("a", "get", STATES),
    ]
    _, _, set_answer, step_answer, *_, final_answer = driver.drive(*calls)
    assert message in set_answer.log[0]
    if flavour == PYTHON:
        assert step_answer.status == "discard"
        assert message in step_answer.log[0]
    else:
        out_of_range = message.startswith(("F =", "mu ="))
        assert set_answer.status == ("discard" if out_of_range else "error")
        assert len(set_answer.log) == 1
        assert step_answer.status == "ok"
    assert final_answer.value == final_state(flavour, 2.0)


def test_a_refused_call_sets_nothing_and_a_valid_value_clears_the_refusal(
    driver: Driver,
) -> None:
    references = [F, REFERENCES["mu"]]
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "set_raw", "Real", references, [100.0, -1.0]),
        ("a", "get_raw", "Real", references),
        ("a", "set", {"mu": 0.8}),
        ("a", "step", 0.0, 1.0),
        ("a", "get_raw", "Real", references),
    ]
    answers = driver.drive(*calls)
    assert answers[2].value == [80.0, 0.7]
    assert answers[4].status == "ok"
    assert answers[5].value == [80.0, 0.8]


@pytest.mark.parametrize(
    ("calls", "message"),
    [
        ([("a", "new")], "do_step is not allowed before initialization"),
        ([("a", "new"), ("a", "setup")], "do_step is not allowed before initialization"),
        (
            [("a", "new"), ("a", "setup"), ("a", "enter")],
            "do_step is not allowed in initialization mode",
        ),
        ([("a", "new"), ("a", "enter"), ("a", "exit")], "not allowed before setup_experiment"),
        ([("a", "begin"), ("a", "setup")], "setup_experiment is not allowed while stepping"),
        ([("a", "begin"), ("a", "enter")], "not allowed while stepping"),
        ([("a", "begin"), ("a", "terminate")], "do_step is not allowed after termination"),
        ([("a", "new"), ("a", "terminate")], "terminate is not allowed before initialization"),
        (
            [("a", "new"), ("a", "setup"), ("a", "enter"), ("a", "terminate")],
            "terminate is not allowed in initialization mode",
        ),
        ([("a", "new"), ("a", "init", {"m": 0.0})], "m = 0: must be from 1e-12 to 1e+09 kg"),
        ([("a", "new"), ("a", "init", {}, float("nan"))], "tolerance = nan: must be from 1e-13"),
        ([("a", "new"), ("a", "init", {"F": -1.0, "k3": 0.0})], "no equilibrium: F = -1 N"),
        ([("a", "new"), ("a", "setup", float("nan"))], "start time = nan"),
        ([("a", "new"), ("a", "setup", 2.0, 1.0)], "stop time = 1"),
    ],
)
def test_a_call_out_of_order_or_an_invalid_setting_is_refused(
    driver: Driver, flavour: str, calls: list[Call], message: str
) -> None:
    # A host may repeat a refused step: the native flavour must log every refusal.
    repeated_step = [("a", "step", 0.0, 0.1)] * 8
    answers = driver.drive(*calls, *repeated_step)
    log_lines = [line for answer in answers for line in answer.log]
    assert any(message in line for line in log_lines)
    if flavour == PYTHON:
        first_step = answers[len(calls)]
        assert first_step.status == "discard"
    else:
        refused = [answer.status != "ok" for answer in answers]
        assert [bool(answer.log) for answer in answers] == refused


@pytest.mark.parametrize("flavour", [PYTHON], indirect=True)
@pytest.mark.parametrize(
    ("calls", "advice"),
    [
        ([("a", "new"), ("a", "step", 0.0, 0.1)], "complete the initialization first"),
        ([("a", "new"), ("a", "enter")], "before setup_experiment; call it first"),
        ([("a", "new"), ("a", "setup"), ("a", "exit")], "call enter_initialization_mode first"),
        ([("a", "begin"), ("a", "setup")], "reset the instance first"),
        ([("a", "begin"), ("a", "set", {"m": 6.0})], "while stepping; reset the instance first"),
        (
            [("a", "begin"), ("a", "set", {"k_nl": -1.0}), ("a", "step", 0.0, 0.1)],
            "repeat the step to go on with the values before",
        ),
    ],
)
def test_the_log_says_what_to_do_after_a_wrong_call(
    driver: Driver, calls: list[Call], advice: str
) -> None:
    assert advice in driver.drive(*calls)[-1].log[-1]


@pytest.mark.parametrize("flavour", [PYTHON], indirect=True)
def test_a_failed_initialization_can_be_corrected_or_reset(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "init", {"m": -1.0}),
        ("a", "step", 0.0, 1.0),
        ("a", "set", {"m": 5.0}),
        ("a", "exit"),
        ("a", "step", 0.0, 1.0),
        ("a", "get", STATES),
        ("a", "reset"),
        ("a", "init"),
        ("a", "step", 0.0, 1.0),
        ("a", "get", STATES),
    ]
    answers = driver.drive(*calls)
    assert answers[2].status == "discard"
    assert answers[5].status == answers[9].status == "ok"
    assert answers[6].value == answers[10].value == final_state(PYTHON, 1.0)


def test_a_step_past_the_stop_time_is_refused(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "setup", 0.0, 1.0),
        ("a", "enter"),
        ("a", "exit"),
        ("a", "step", 0.0, 1.5),
        # Hosts add up times with rounding errors: up to 1e-9 s are accepted.
        ("a", "step", 0.0, 1.0 + 1e-12),
    ]
    answers = driver.drive(*calls)
    assert [answer.status for answer in answers[-2:]] == ["discard", "ok"]
    assert "after the stop time 1.0 s" in answers[-2].log[0]


def test_step_times_must_agree_to_rounding_at_any_time(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "setup", 1e6),
        ("a", "enter"),
        ("a", "exit"),
        ("a", "step", 1e6 + 1e-4, 1e-3),
        # Off by two spacings of floats at 1e6.
        ("a", "step", 1e6 + 2e-10, 1e-3),
    ]
    answers = driver.drive(*calls)
    assert [answer.status for answer in answers[-2:]] == ["discard", "ok"]
    assert "the FMU is at 1000000.0 s" in answers[-2].log[0]


def test_a_short_step_past_the_stop_time_is_refused_too(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "setup", 0.0, 0.0105),
        ("a", "enter"),
        ("a", "exit"),
        ("a", "steps", 0.0, 1e-3, 10),
        ("a", "step", 0.01, 1e-3),
        ("a", "step", 0.01, 0.5e-3),
    ]
    answers = driver.drive(*calls)
    assert [answer.status for answer in answers[-3:]] == ["ok", "discard", "ok"]


@pytest.mark.parametrize("separation", [False, True])
def test_a_motion_beyond_the_floating_point_range_is_refused_with_cause_and_advice(
    driver: Driver, separation: bool
) -> None:
    values = {"k2": 186.0, "k_nl": 0.0, "mu": 90.0, "separation": separation}
    calls: list[Call] = [
        ("a", "begin", values),
        ("a", "step", 0.0, 10.0),
        ("a", "get", STATES),
        ("a", "step", 10.0, 1e5),
        ("a", "get", STATES),
        ("a", "step", 10.0, 1.0),
    ]
    _, _, state_before, failed_step, state_after, next_step = driver.drive(*calls)
    assert failed_step.status == "discard"
    assert "grows beyond the floating-point range" in failed_step.log[0]
    # The advice depends on k_nl and separation alone.
    system = System(Parameters(k_nl=0.0), separation=separation)
    advice = overflow_error(0.0, (1e200, 0.0, 1e200, 0.0), system).advice
    assert failed_step.log[0].endswith(f"; {advice}")
    assert state_before.value == state_after.value
    assert next_step.status == "ok"


def test_hundreds_of_refused_calls_do_not_change_an_instance(driver: Driver, flavour: str) -> None:
    # In the Python flavour the refusals before it make even a valid step fail.
    refused_step_size = 1.0 if flavour == PYTHON else math.nan
    refused_calls = [
        ("a", "step", 5.0, -1.0),
        ("a", "set_raw", "Real", [999], [1.0]),
        ("a", "get_raw", "Real", [999]),
        ("a", "get_raw", "String", [0]),
        ("a", "setup"),
        ("a", "step", 0.0, refused_step_size),
    ]
    calls = [("a", "begin"), *refused_calls * 60, ("a", "step", 0.0, 1.0), ("a", "get", STATES)]
    answers = driver.drive(*calls)
    assert answers[-2].status == "ok"
    assert answers[-1].value == final_state(flavour, 1.0)


def test_without_logging_a_refused_call_fails_and_the_native_flavour_gives_the_reason(
    driver: Driver, flavour: str
) -> None:
    fmu_index, logging = 0, False
    calls: list[Call] = [
        ("a", "new", fmu_index, logging),
        ("a", "init"),
        ("a", "set", {"mu": -1.0}),
        ("a", "step", 0.0, 1.0),
    ]
    answers: list[Answer] = driver.drive(*calls)
    if flavour == PYTHON:
        assert answers[-1] == Answer("discard", None, [])
    else:
        set_answer = answers[-2]
        assert (set_answer.status, len(set_answer.log)) == ("discard", 1)
        assert "mu = -1: must be" in set_answer.log[0]


def test_variables_of_any_type_can_be_read_as_real_and_as_integer(driver: Driver) -> None:
    references = [SEPARATION, REFERENCES["mode"], REFERENCES["mode_integer"]]
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "get_raw", "Real", references),
        ("a", "get_raw", "Integer", references),
        ("a", "get_raw", "Boolean", references),
    ]
    for answer in driver.drive(*calls)[1:]:
        assert answer.value == [1, 1, 1]


def test_outputs_can_be_read_in_initialization_mode(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "setup"),
        ("a", "enter"),
        ("a", "set", {"F": 40.0}),
        ("a", "get", ["y"]),
        ("a", "exit"),
        ("a", "get", ["y"]),
    ]
    answers = driver.drive(*calls)
    assert answers[4].value == answers[6].value
    # The static deflection (m) under a preload of 40 N.
    assert -0.5 < answers[4].value[0] < -0.2


def test_a_friction_law_too_steep_for_floating_point_is_refused_with_advice(driver: Driver) -> None:
    values = {"finite_belt": True, "v_belt": 1.0, "mu_s": 0.9, "v_s": 1e-12}
    values |= {"m": 1e-12, "k2": 1e12}
    _, failed_step = driver.drive(("a", "begin", values), ("a", "step", 0.0, 20.0))
    assert "changes faster than floating-point" in failed_step.log[0]
    assert "a larger v_s" in failed_step.log[0]

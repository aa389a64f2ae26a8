"""The brake actuator: its lag, its feedback, its state, and what it refuses.

In scripts `new` creates an instance, `init` sets its values and initializes it, `begin` does both.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.fmu_driver import Call, Driver
from tests.support.fmu_tools import build_python_fmu


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_python_fmu(
        tmp_path_factory.mktemp("fmu") / "brake_actuator.fmu", component="brake-actuator"
    )


@pytest.fixture(scope="module")
def driver(fmu: Path) -> Iterator[Driver]:
    with Driver(fmu) as driver:
        yield driver


@pytest.mark.parametrize("h", [1e-3, 0.05, 0.5])
def test_the_preload_follows_the_command_with_a_lag_and_with_feedback(
    driver: Driver, h: float
) -> None:
    count = round(0.5 / h)
    calls: list[Call] = [
        ("a", "begin", {"tau": 0.2, "gain": 0.5, "F_start": 10.0}),
        ("a", "get", ["F", "F_rate"]),
        ("a", "set", {"command": 60.0, "P": 40.0}),
        ("a", "steps", 0.0, h, count),
        ("a", "get", ["F", "F_rate"]),
    ]
    _, start, _, _, end = driver.drive(*calls)
    # By default command and P are 80 N, so that the target of F is 80 N, too.
    assert start.value == pytest.approx([10.0, (80.0 - 10.0) / 0.2])
    target_force = 60.0 + 0.5 * (60.0 - 40.0)
    expected = target_force + (10.0 - target_force) * math.exp(-0.5 / 0.2)
    assert end.value == pytest.approx([expected, (target_force - expected) / 0.2], rel=1e-12)


def test_rollback_and_serialisation_are_exact(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "set", {"command": 100.0}),
        ("a", "step", 0.0, 0.03),
        ("a", "save", "saved"),
        ("a", "set", {"command": 20.0}),
        ("a", "step", 0.03, 0.04),
        ("a", "get", ["F"]),
        ("b", "begin", {"tau": 0.1}),
        # "copy" is the state "saved" of the other instance, serialised and deserialised.
        ("b", "serialize", "saved", "copy"),
        ("b", "restore", "copy"),
        ("b", "get", ["F", "command", "tau"]),
        ("b", "set", {"command": 20.0}),
        ("b", "step", 0.03, 0.04),
        ("b", "get", ["F"]),
    ]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    preload, restored, restored_preload = (
        answer.value for answer in answers if isinstance(answer.value, list)
    )
    assert preload == restored_preload
    _, *command_and_tau = restored
    assert command_and_tau == [100.0, 0.05]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tau": 0.0}, "tau = 0: must be from 1e-12"),
        ({"gain": -1.0}, "gain = -1: must be from 0"),
        ({"command": 1e10}, "command = 1e+10: must be from"),
        ({"P": math.nan}, "P = nan: not a finite number"),
    ],
)
def test_a_wrong_value_is_refused(driver: Driver, values: dict[str, float], message: str) -> None:
    answers = driver.drive(("a", "new"), ("a", "init", values), ("a", "step", 0.0, 0.1))
    assert answers[-1].status == "discard"
    assert message in "".join(line for answer in answers for line in answer.log)


def test_a_preload_out_of_the_range_of_numbers_is_refused_with_advice(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "begin", {"gain": 1000.0}),
        ("a", "set", {"P": -1.7e308}),
        ("a", "step", 0.0, 0.1),
        ("a", "set", {"P": 80.0}),
        ("a", "step", 0.0, 0.1),
    ]
    _, _, overflow, _, repetition = driver.drive(*calls)
    (message,) = overflow.log
    assert "beyond the floating-point range" in message
    assert message.endswith("; use a smaller command, a smaller gain or a smaller contact force")
    assert (overflow.status, repetition.status) == ("discard", "ok")

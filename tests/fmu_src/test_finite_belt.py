"""The FMU on a belt of finite speed: modes, friction, events, states, refusals."""

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Final

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model import Mode, friction_force
from fivtui.transient import KernelChoice, Transient
from fmu_src.build.builder import NATIVE, PYTHON
from fmu_src.slave.variables import VARIABLES
from tests.support.fmu_driver import Call, Driver

REAL_NAMES: Final = [v.name for v in VARIABLES if v.type == "Real"]
STATES: Final = ["x", "vx", "y", "vy"]
OUTPUTS: Final = [*STATES, "P", "mode", "friction_slider", "friction_belt"]
COUNTS: Final = ["separations", "reattachments", "switches", "sticks", "last_event"]
KERNELS: Final[Mapping[str, KernelChoice]] = {PYTHON: "interpreted", NATIVE: "compiled"}
# Parameters, and the start x, vx, y, vy; None is a start at rest. Stick and slip; friction that
# falls with speed; all modes of a belt of finite speed, separation included; a belt at rest.
SCENES: Final = {
    "stick-slip": (Parameters(v_belt=1.0), None),
    "falling": (Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4), None),
    "all": (Parameters(v_belt=2.0, mu_s=0.8, v_s=0.4), (2.0, 8.0, 1.0, 0.0)),
    "at rest": (Parameters(v_belt=0.0, mu_s=0.8), (0.0, 0.0, -0.4, 1.0)),
}


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest) -> str:
    """A name of `SCENES`."""
    name: str = request.param
    return name


def start_values(name: str) -> dict[str, float | bool]:
    p, start = SCENES[name]
    values: dict[str, float | bool] = {**p.as_dict(), "finite_belt": True}
    if start is not None:
        values["start_static"] = False
        values |= {f"{n}_start": x for n, x in zip(STATES, start, strict=True)}
    return values


def native_run(name: str, **options: Any) -> Transient:
    p, start = SCENES[name]
    return simulate(p, start="static" if start is None else start, **options)


def switches_until(run: Transient, t: float) -> tuple[list[float], float]:
    """Separations, reattachments, mode changes and sticks up to `t`; time of the last change."""
    modes = [run.first_mode]
    switch_time = 0.0
    separations = reattachments = 0
    for change_time, before, after in run.mode_changes:
        if change_time <= t:
            modes.append(after)
            switch_time = change_time
            separations += after is Mode.SEPARATED
            reattachments += before is Mode.SEPARATED
    return [separations, reattachments, len(modes) - 1, modes.count(Mode.STICK)], switch_time


@pytest.mark.parametrize("h", [1e-3, 1e-2, 0.1])
def test_the_fmu_has_the_native_motion_at_every_communication_step(
    driver: Driver, flavour: str, scene: str, h: float
) -> None:
    calls: list[Call] = [("a", "begin", start_values(scene)), ("a", "get", OUTPUTS + COUNTS)]
    times = [0.0]
    for _ in range(round((0.4 if h < 5e-3 else 4.0) / h)):
        calls += [("a", "step", times[-1], h), ("a", "get", OUTPUTS + COUNTS)]
        times.append(times[-1] + h)
    rows = [answer.value for answer in driver.drive(*calls)[1::2]]
    native = native_run(scene, t_end=times[-1], samples=times, kernel=KERNELS[flavour])
    motion = native.trajectory
    assert motion is not None
    columns = (motion.x, motion.vx, motion.y, motion.vy, motion.P, motion.mode)
    samples = np.transpose(columns).tolist()
    p, *_ = SCENES[scene]
    for row, t, sample in zip(rows, times, samples, strict=True):
        x, vx, y, vy, P, mode, friction_slider, friction_belt, *counts_and_time = row
        motion_values = [x, vx, y, vy, P, mode]
        if flavour == NATIVE:
            assert motion_values == sample
        # In stick the Python FMU gives exactly the belt's speed, the native run that of a Taylor
        # polynomial, which differs by rounding.
        assert motion_values == pytest.approx(sample, rel=1e-14, abs=1e-14)
        friction = friction_force(p, (x, vx, y, vy), Mode(int(mode)))
        assert friction_slider == pytest.approx(friction, rel=1e-12, abs=1e-12)
        assert friction_belt == -friction_slider
        counts, last_event = switches_until(native, t)
        assert counts_and_time == [*counts, last_event]


def test_the_scenes_have_all_modes() -> None:
    changes = native_run("all", t_end=4.0).mode_changes
    assert {change.then for change in changes} == {*Mode} - {Mode.CONTACT}
    assert native_run("at rest", t_end=4.0).first_mode is Mode.STICK


@lru_cache
def rk4_run(name: str) -> Transient:
    return native_run(name, t_end=1.0, method="rk4", step=4e-3)


def test_the_fmu_agrees_with_the_independent_rk4(driver: Driver, scene: str) -> None:
    calls: list[Call] = [
        ("a", "begin", start_values(scene)),
        ("a", "steps", 0.0, 0.125, 8),
        ("a", "get", [*STATES, "switches"]),
    ]
    *state, switches = driver.drive(*calls)[-1].value
    rk4 = rk4_run(scene)
    assert state == pytest.approx(rk4.final[1:], abs=1e-6)
    assert switches == sum(rk4.events.transitions.values())


JUMPS: Final[dict[str, list[tuple[float, float]]]] = {
    "F": [(0, 80), (1, 80), (1, 120), (3, 120), (3, 40)],
    "mu": [(0, 0.7), (1.5, 0.7), (1.5, 0.5), (3.5, 0.5), (3.5, 0.85)],
    "v_belt": [(0, 1), (2, 1), (2, 0.4), (2.5, 0.4), (2.5, 3), (4, 3), (4, 0)],
}


@pytest.mark.parametrize("is_static_friction_mu", [True, False])
def test_inputs_that_jump_give_the_motion_of_native_tables_with_jumps(
    driver: Driver, is_static_friction_mu: bool
) -> None:
    p = Parameters() if is_static_friction_mu else Parameters(mu_s=0.9, v_s=0.4)
    run = simulate(p, t_end=6.0, over_time=JUMPS)
    start = {name: rows[0][1] for name, rows in JUMPS.items()}
    calls: list[Call] = [("a", "begin", {**p.as_dict(), **start, "finite_belt": True})]
    for number in range(60):
        t = 0.1 * number
        inputs = {
            name: [value for time, value in rows if time <= t + 1e-9][-1]
            for name, rows in JUMPS.items()
        }
        calls += [("a", "set", inputs), ("a", "step", t, 0.1)]
    *state, mode, switches, sticks, separations = driver.drive(
        *calls, ("a", "get", [*STATES, "mode", "switches", "sticks", "separations"])
    )[-1].value
    assert state == pytest.approx(run.final[1:], abs=1e-10)
    events = run.events
    counts = [sum(events.transitions.values()), events.sticks, events.separations]
    assert [switches, sticks, separations] == counts
    assert mode == run.mode_changes[-1].then
    assert events.sticks > 4


def test_outputs_follow_a_jump_of_the_belt_at_once(driver: Driver) -> None:
    read = [*OUTPUTS, "v_belt", "ax"]
    begin, end = simulate(Parameters(v_belt=1.0, mu_s=0.9), t_end=4.0).stick_intervals[1]
    calls: list[Call] = [
        ("a", "begin", {"finite_belt": True, "v_belt": 1.0, "mu_s": 0.9}),
        ("a", "step", 0.0, 0.5 * (begin + end)),
    ]
    for speed, mode in ((2.0, Mode.FORWARD), (0.5, Mode.BACKWARD), (1.0, Mode.STICK)):
        calls += [("a", "set", {"v_belt": speed}), ("a", "get", read)]
        x, vx, y, vy, _, read_mode, friction, *_, ax = driver.drive(*calls)[-1].value
        p = Parameters(v_belt=speed, mu_s=0.9)
        assert (read_mode, vx) == (mode, 1.0)
        assert friction == pytest.approx(friction_force(p, (x, vx, y, vy), mode), rel=1e-14)
        # The spring k3 is at 45°.
        spring_forces = p.k1 * x + p.k3 / 2.0 * (x - y)
        assert ax == pytest.approx((friction - p.c1 * vx - spring_forces) / p.m, abs=1e-12)


def test_without_a_finite_belt_its_parameters_have_no_effect(driver: Driver) -> None:
    belt = {"mu_s": 0.1, "v_s": 0.2}
    excluded_indices = [REAL_NAMES.index(name) for name in belt]
    values_read = []
    for values in ({}, belt):
        calls: list[Call] = [
            ("a", "begin", values),
            ("a", "steps", 0.0, 0.3, 10),
            # Some hosts set inputs that are not connected to 0.
            ("a", "set", {"v_belt": 0.0}),
            ("a", "steps", 3.0, 0.3, 10),
            ("a", "get", REAL_NAMES),
        ]
        *earlier, read = driver.drive(*calls)
        assert {answer.status for answer in earlier} == {"ok"}
        values_read.append([v for n, v in enumerate(read.value) if n not in excluded_indices])
    without, with_belt_values = values_read
    assert without == with_belt_values
    native = simulate(t_end=6.0, kernel="interpreted").final
    assert without[REAL_NAMES.index("y")] == pytest.approx(native.y, rel=1e-9)


def test_an_input_set_and_set_back_changes_no_bit(driver: Driver) -> None:
    ends = []
    for disturbed in (False, True):
        calls: list[Call] = [("a", "begin", start_values("falling"))]
        for number in range(40):
            if disturbed:
                calls += [("a", "set", {"v_belt": 3.0}), ("a", "set", {"v_belt": 0.5})]
            calls.append(("a", "step", 0.05 * number, 0.05))
        ends.append(driver.drive(*calls, ("a", "get", REAL_NAMES))[-1].value)
    assert ends[0] == ends[1]


# Times in each mode of the scene "all", inside integrator steps.
@pytest.mark.parametrize("mode", [Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK])
def test_states_are_restored_bit_by_bit_in_every_mode(driver: Driver, mode: Mode) -> None:
    run = native_run("all", t_end=6.0)
    changes = run.mode_changes
    index = next(n for n, change in enumerate(changes[:-1]) if change.then is mode)
    t = 0.6 * changes[index].t + 0.4 * changes[index + 1].t
    continuation: list[Call] = [
        ("a", "steps", t, 0.01, 30),
        ("a", "set", {"v_belt": 0.5, "F": 60.0}),
        ("a", "steps", t + 0.3, 0.07, 30),
        ("a", "get", REAL_NAMES),
    ]
    restored_calls: list[Call] = [("b", *call[1:]) for call in continuation]
    # Read values where the state is saved, and at the end of each continuation.
    calls: list[Call] = [
        # The original run.
        ("a", "begin", start_values("all")),
        ("a", "step", 0.0, t),
        ("a", "get", REAL_NAMES),
        ("a", "save", "saved"),
        *continuation,
        # Restored.
        ("a", "restore", "saved"),
        ("a", "get", REAL_NAMES),
        *continuation,
        # Deserialised in another instance.
        ("a", "serialize", "saved", "copy"),
        ("b", "begin"),
        ("b", "step", 0.0, 1.0),
        ("b", "restore", "copy"),
        ("b", "get", REAL_NAMES),
        *restored_calls,
        # Repeated after a reset.
        ("a", "reset"),
        ("a", "init", start_values("all")),
        ("a", "step", 0.0, t),
        ("a", "get", REAL_NAMES),
        *continuation,
        ("a", "forget", "saved"),
        ("b", "forget", "copy"),
    ]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    reads = [answer.value for answer in answers if isinstance(answer.value, list)]
    at_save, at_end = reads[::2], reads[1::2]
    assert at_save == [at_save[0]] * 4
    assert at_save[0][REAL_NAMES.index("mode")] == mode
    assert at_end == [at_end[0]] * 4
    assert at_end[0] != at_save[0]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"v_belt": -2e9}, "v_belt = -2e+09: must be from -1e+09 to 1e+09 m/s"),
        ({"v_belt": math.nan}, "v_belt = nan: not a finite number"),
        ({"v_belt": math.inf}, "v_belt = inf: not a finite number"),
        ({"mu": 0.95}, "mu = 0.95: must be at most mu_s = 0.9"),
        ({"finite_belt": False}, "finite_belt cannot be set while stepping"),
        ({"mu_s": 0.65}, "mu = 0.7: must be at most mu_s = 0.65"),
        ({"v_s": -0.1}, "v_s = -0.1: must be from 0"),
        ({"m": 6.0}, "m cannot be set while stepping"),
    ],
)
def test_wrong_values_during_a_run_are_refused_and_change_nothing(
    driver: Driver, flavour: str, values: dict[str, Any], message: str
) -> None:
    calls: list[Call] = [
        ("a", "begin", start_values("falling")),
        ("a", "step", 0.0, 1.0),
        ("a", "get", REAL_NAMES),
        ("a", "set", values),
        ("a", "get", REAL_NAMES),
        ("a", "step", 1.0, 0.5),
        ("a", "step", 1.0, 0.5),
        ("a", "get", REAL_NAMES),
    ]
    *_, before, refused, after, first, second, end = driver.drive(*calls)
    assert message in refused.log[0]
    assert before.value == after.value
    if flavour == PYTHON:
        # The next step reports the refused call and does not advance; the second repeats it.
        assert (refused.status, first.status, second.status) == ("ok", "discard", "ok")
        native = native_run("falling", t_end=1.5, kernel="interpreted").final
        assert end.value[REAL_NAMES.index("y")] == native.y
    else:
        # The call itself fails, so the first step advances, and the second has a wrong start.
        assert refused.status in ("discard", "error")
        assert (first.status, second.status) == ("ok", "discard")


@pytest.mark.parametrize("order", [("mu_s", "mu"), ("mu", "mu_s")])
def test_static_friction_below_friction_is_refused_on_a_finite_belt(
    driver: Driver, order: tuple[str, str]
) -> None:
    wrong = {name: {"mu_s": 0.5, "mu": 0.6}[name] for name in order}
    for finite in (True, False):
        calls: list[Call] = [
            ("a", "begin", {**wrong, "finite_belt": finite}),
            ("a", "step", 0.0, 0.1),
        ]
        initialized, step = driver.drive(*calls)
        reported = any("mu = 0.6: must be at most mu_s = 0.5" in line for line in initialized.log)
        assert reported is finite
        assert (step.status == "ok") is not finite
    equal = dict.fromkeys(order, 0.6)
    start, step = driver.drive(
        ("a", "begin", {**equal, "finite_belt": True}), ("a", "step", 0.0, 0.1)
    )
    assert (start.log, step.status) == ([], "ok")


@pytest.mark.parametrize(
    ("values", "messages"),
    [
        ({"mu_s": 0.9}, ["mu_s has no effect without finite_belt"]),
        ({"mu_s": 0.9, "v_s": 0.4}, ["mu_s, v_s have no effect without finite_belt"]),
        ({"finite_belt": True, "v_s": 0.4}, ["v_s has no effect without mu_s"]),
        ({"finite_belt": True, "mu_s": 0.9, "v_s": 0.4}, []),
        ({"finite_belt": True, "mu_s": 0.9}, []),
        ({}, []),
    ],
)
def test_values_without_effect_are_logged_once(
    driver: Driver, values: dict[str, float | bool], messages: list[str]
) -> None:
    answers = driver.drive(("a", "begin", values), ("a", "steps", 0.0, 0.1, 3))
    assert [answer.status for answer in answers] == ["ok", "ok"]
    assert [text for answer in answers for text in answer.log] == messages

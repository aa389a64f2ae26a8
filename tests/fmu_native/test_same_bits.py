"""Co-simulation by the native FMU: the bits of the native solver at every communication point."""

import itertools
import threading
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import given, settings, strategies as st

from fivtui import Parameters, simulate
from tests.support.fmu_instance import FmuInstance
from tests.support.strategies import moderate_parameters

COLUMNS = ("x", "vx", "y", "vy", "P", "mode")
STATES = COLUMNS[:4]


def assert_same_bits(folder: Path, steps: list[float], tol: float, p: Parameters) -> None:
    times, rows = [0.0], []
    start_values = {**p.as_dict(), "finite_belt": p.v_belt is not None}
    with FmuInstance(folder).begin(tol=tol, **start_values) as instance:
        rows.append(instance.get(*COLUMNS))
        for h in steps:
            instance.step(h)
            times.append(instance.t)
            rows.append(instance.get(*COLUMNS))
        separations, reattachments, last_event = instance.get(
            "separations", "reattachments", "last_event"
        )
    native = simulate(p, t_end=times[-1], tol=tol, samples=times, kernel="compiled")
    assert native.trajectory is not None
    for column, name in enumerate(COLUMNS):
        samples = np.array([row[column] for row in rows])
        assert np.array_equal(samples, getattr(native.trajectory, name)), name
    assert separations + reattachments == native.switch_times.size
    # `switch_times` are those of separations and reattachments. On a belt of finite speed `changes`
    # has all switches: time, mode before, mode after.
    event_times = native.switch_times if p.v_belt is None else native.changes[:, 0]
    assert last_event == (event_times[-1] if event_times.size else 0.0)


@pytest.mark.parametrize("tol", [1e-13, 1e-12, 1e-9, 1e-8, 1e-6, 5e-6, 1e-3, 3e-3, 1e-2])
def test_bits_are_native_at_random_communication_points(folder: Path, tol: float) -> None:
    rng = np.random.default_rng(round(-np.log10(tol)))
    step_sizes = [1e-3, 1e-2, 0.1, 1.0, 10.0]
    steps = [float(rng.choice([*step_sizes, rng.uniform(0.0, 1.0)])) for _ in range(80)]
    assert_same_bits(folder, steps, tol, Parameters())


@pytest.mark.parametrize("h", [1e-3, 1e-2, 10.0])
def test_bits_are_native_at_equal_steps(folder: Path, h: float) -> None:
    assert_same_bits(folder, [h] * min(round(100.0 / h), 2000), 1e-12, Parameters())


@pytest.mark.parametrize("tol", [1e-12, 1e-9, 1e-5])
def test_bits_are_native_on_belts_of_finite_speed(folder: Path, tol: float) -> None:
    for values in ({"v_belt": 0.2, "v_s": 0.1}, {"v_belt": 3.0, "v_s": 0.4}, {"v_belt": 1.0}):
        assert_same_bits(folder, [0.7] * 60, tol, Parameters(mu_s=0.9).with_values(values))


@settings(max_examples=25)
@given(moderate_parameters(), st.lists(st.floats(1e-4, 2.0), min_size=1, max_size=12))
def test_bits_are_native_for_random_parameters(
    folder: Path, p: Parameters, steps: list[float]
) -> None:
    assert_same_bits(folder, steps, 1e-12, p)


def test_a_jump_of_inputs_restarts_the_native_solver(folder: Path) -> None:
    first = simulate(t_end=3.7, samples=[3.7], kernel="compiled").trajectory
    assert first is not None
    # x, vx, y, vy.
    state = tuple(float(getattr(first, name)[0]) for name in STATES)
    p = Parameters(F=120.0, mu=0.4)
    second = simulate(p, t_end=2.5, start=state, kernel="compiled").final
    with FmuInstance(folder).begin() as instance:
        instance.step(3.7)
        instance.set(F=120.0, mu=0.4)
        instance.step(2.5)
        # The time starts elsewhere, which changes results only by rounding.
        assert instance.get(*STATES) == pytest.approx(
            [second.x, second.vx, second.y, second.vy], rel=1e-12, abs=1e-12
        )


def test_an_input_that_is_set_and_set_back_changes_no_bit(folder: Path) -> None:
    with FmuInstance(folder).begin() as plain, FmuInstance(folder).begin() as disturbed:
        for _ in range(30):
            disturbed.set(F=10.0)
            disturbed.set(F=80.0)
            for instance in (plain, disturbed):
                instance.step(0.01)
        assert plain.get(*COLUMNS) == disturbed.get(*COLUMNS)


def test_instances_in_threads_are_independent(folder: Path) -> None:
    forces = [40.0 + 5.0 * number for number in range(8)]
    instances = [FmuInstance(folder).begin(F=F) for F in forces]

    def drive(instance: FmuInstance) -> None:
        for _ in range(300):
            instance.step(0.05)

    threads = [threading.Thread(target=drive, args=(instance,)) for instance in instances]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for F, instance in zip(forces, instances, strict=True):
        (t,) = {instance.t}
        native = simulate(Parameters(F=F), t_end=t, kernel="compiled").final
        assert instance.get(*STATES) == [native.x, native.vx, native.y, native.vy]
        instance.fmi.freeInstance()


def state_after_ramps(folder: Path, count: int, slopes: bool) -> list[float]:
    """The state after 5 s with F = 80 + 8 t and μ = 0.7 − 0.05 t, in `count` steps."""
    h = 5.0 / count
    with FmuInstance(folder).begin() as instance:
        for number in range(count):
            t = number * h if slopes else (number + 0.5) * h
            instance.t = number * h
            instance.set(F=80.0 + 8.0 * t, mu=0.7 - 0.05 * t)
            if slopes:
                instance.set_slopes(F=8.0, mu=-0.05)
            instance.step(h)
        return instance.get(*STATES)


def test_input_derivatives_follow_a_ramp_at_any_step_size(folder: Path) -> None:
    runs = [state_after_ramps(folder, count, True) for count in (1, 7, 100, 1000)]
    for first, second in itertools.pairwise(runs):
        assert first == pytest.approx(second, rel=1e-10, abs=1e-10)
    # An input held at its mean causes an error of second order: half the step, a quarter of the
    # error. So the exact state is beyond the fine one by a third of the change (Richardson).
    coarse, fine = (state_after_ramps(folder, count, False) for count in (1000, 2000))
    limit = [f + (f - c) / 3.0 for c, f in zip(coarse, fine, strict=True)]
    assert runs[0] == pytest.approx(limit, abs=1e-7)


def test_after_a_ramp_the_input_keeps_its_final_value(folder: Path) -> None:
    with FmuInstance(folder).begin() as instance:
        instance.set_slopes(F=-5.0)
        instance.step(2.0)
        assert instance.get("F") == [70.0]
        instance.step(1.0)
        assert instance.get("F") == [70.0]


@pytest.mark.parametrize("count", [1, 50])
def test_after_a_ramp_the_inputs_are_held(folder: Path, count: int) -> None:
    with FmuInstance(folder).begin() as instance:
        instance.set_slopes(F=-500.0, mu=2.0)
        instance.step(1.0 / 1024.0)
        state, (F, mu) = instance.get(*STATES), instance.get("F", "mu")
        for _ in range(count):
            instance.step(0.0625 / count)
        values = instance.get(*STATES)
    expected = simulate(Parameters(F=F, mu=mu), t_end=0.0625, start=state, kernel="compiled").final
    assert values == pytest.approx(
        [expected.x, expected.vx, expected.y, expected.vy], rel=1e-13, abs=1e-14
    )


def test_a_ramp_out_of_the_range_of_its_input_is_refused(folder: Path) -> None:
    with FmuInstance(folder).begin() as instance:
        instance.set_slopes(mu=-1.0)
        with pytest.raises(FMICallException, match="discard"):
            instance.step(1.0)
        assert "mu = -0.3 at the end of the step: must be from 0 to 100" in instance.log[-1]
        # The slope still applies: 0.7 − 1.0 · 0.5.
        instance.step(0.5)
        assert instance.get("mu") == pytest.approx([0.2])

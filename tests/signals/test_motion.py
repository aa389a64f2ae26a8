"""Motion of a run at any time, its period, and time windows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fivtui.model import InputError, Mode, Parameters
from fivtui.signals.motion import (
    check_window,
    is_rest,
    last_cycles,
    modes_at,
    motion_at,
    period_of,
)
from fivtui.simulation import simulate

STICKING = Parameters(v_belt=3.0, mu_s=0.9, v_s=0.4)


def test_motion_between_samples_agrees_with_the_dense_solution() -> None:
    dense, sampled = simulate(t_end=20.0, samples="dense"), simulate(t_end=20.0, samples=2001)
    times = np.linspace(0.0, 20.0, 777)
    expected, actual = motion_at(dense, times), motion_at(sampled, times)
    for name, size in (("x", 1e-5), ("y", 1e-5), ("vx", 5e-3), ("vy", 5e-3), ("P", 0.02)):
        assert np.abs(getattr(actual, name) - getattr(expected, name)).max() < size, name
    assert np.array_equal(actual.mode, expected.mode)
    assert actual.P[actual.mode == Mode.SEPARATED].max() == 0.0
    with pytest.raises(InputError, match="compute it with sample times"):
        motion_at(simulate(t_end=1.0), times[:1])


def test_a_motion_below_a_billionth_of_the_displacement_is_rest() -> None:
    run = simulate(t_end=1.0, samples=2)
    assert run.trajectory is not None
    for size in (1e-3, 1.0, 1e6):
        for relative_size, rests in ((0.5e-9, True), (2e-9, False)):
            moving, rest_samples = size * np.array([1.0, 1.0 + relative_size]), np.zeros(2)
            for x, y in ((moving, rest_samples), (rest_samples, moving)):
                assert is_rest(replace(run.trajectory, x=x, y=y)) is rests


def test_motion_at_a_sample_time_equals_the_sample() -> None:
    run = simulate(t_end=5.0, samples=51)
    assert run.trajectory is not None
    motion = motion_at(run, run.trajectory.t)
    for name in ("x", "vx", "y", "vy", "P"):
        assert getattr(motion, name) == pytest.approx(getattr(run.trajectory, name), abs=1e-9)


def test_modes_between_samples_follow_the_located_switches() -> None:
    run = simulate(STICKING, t_end=20.0, samples=11)
    assert run.events.sticks > 0
    for start, end in run.stick_intervals:
        assert modes_at(run, np.array([0.5 * (start + end)])) == [Mode.STICK]
    for start, end in run.separated_intervals:
        assert modes_at(run, np.array([0.5 * (start + end)])) == [Mode.SEPARATED]


def test_the_period_is_that_of_the_limit_cycle_and_a_run_at_rest_has_none() -> None:
    run, cycle_period = simulate(t_end=400.0, samples="dense"), 1.3264574885
    assert period_of(run) == pytest.approx(cycle_period, rel=1e-4)
    # The window has eight cycles.
    start, end = last_cycles(run)
    assert end == 400.0
    assert end - start == pytest.approx(8 * cycle_period, rel=1e-4)
    rest = simulate(Parameters(mu=0.0), t_end=30.0, samples="dense")
    assert period_of(rest) is None
    assert last_cycles(rest) == (0.0, 30.0)


@pytest.mark.parametrize(
    "window", [(-1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (0.0, 5.1), (0.0, math.nan)]
)
def test_a_window_must_be_within_the_run(window: tuple[float, float]) -> None:
    run = simulate(t_end=5.0)
    assert check_window(run, (0.0, 5.0)) == (0.0, 5.0)
    with pytest.raises(InputError, match="must be two ascending times from 0 to 5 s"):
        check_window(run, window)

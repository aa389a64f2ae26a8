"""Tests of the motion on a belt of finite speed."""

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.model.field import exponential
from fivtui.model.modes import MODES, Mode, transition_name
from fivtui.model.slider_belt import State
from fivtui.taylor.belt import BeltStepper
from fivtui.transient.request import KernelChoice, Start
from fivtui.transient.result import Transient, complete_events
from tests.support.energy import mechanical_energy, power

from .test_model import belts

# A mass without coupling and dampers. At y = -1 m the contact force is P = 1 N: the mass sticks
# until x = mu_s P/k1 = 1 m, then slips in a harmonic oscillation about x = mu P/k1 = 0.5 m.
UNIT_MASS = Parameters(
    m=1.0, k1=1.0, k2=1.0, k3=0.0, c1=0.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.5, mu_s=1.0, v_belt=0.2
)
# Period of its stick-slip cycle, s.
CYCLE_PERIOD = 8.902605407814523
KERNELS: tuple[KernelChoice, ...] = ("interpreted", "compiled")
kernels = pytest.mark.parametrize("kernel", KERNELS)


@kernels
def test_a_mass_on_a_belt_has_the_period_in_closed_form(kernel: KernelChoice) -> None:
    run = simulate(UNIT_MASS, t_end=60.0, start=(0.0, 0.2, -1.0, 0.0), kernel=kernel)
    # The slip begins and ends at the belt speed, at a distance mu_s - mu on either side of 0.5 m.
    drop, speed = 0.5, 0.2
    stick_time = 2.0 * drop / speed
    slip_time = 2.0 * (math.pi - math.atan(drop / speed))
    assert stick_time + slip_time == pytest.approx(CYCLE_PERIOD, rel=1e-15)
    for kind in (Mode.STICK, Mode.FORWARD):
        begin_times = np.array([change.t for change in run.mode_changes if change.then is kind])
        assert np.diff(begin_times) == pytest.approx(CYCLE_PERIOD, rel=1e-12)
    assert run.events.transitions == {"forward-stick": 6, "stick-forward": 7}
    assert (run.events.sticks, len(run.stick_intervals)) == (7, 7)
    assert run.events.stick_time == pytest.approx(7 * stick_time, rel=1e-12)


@kernels
def test_a_stick_in_progress_ends_with_the_run(kernel: KernelChoice) -> None:
    run = simulate(UNIT_MASS, t_end=8.0, start=(0.0, 0.2, -1.0, 0.0), kernel=kernel)
    assert np.array(run.stick_intervals) == pytest.approx(np.array([[0.0, 5.0]]), rel=1e-12)
    run_in_stick = simulate(UNIT_MASS, t_end=2.0, start=(0.0, 0.2, -1.0, 0.0), kernel=kernel)
    assert run_in_stick.stick_intervals == [(0.0, 2.0)]
    assert (run_in_stick.events.sticks, run_in_stick.events.stick_time) == (1, 2.0)
    # The start of the stick in which the run ends.
    assert run_in_stick.final_stick == 0.0


@pytest.mark.parametrize("v_belt", [0.0, 0.2, 1.0, 3.0])
def test_counts_of_sticks_and_switches_match_the_mode_changes(v_belt: float) -> None:
    p = Parameters(v_belt=v_belt, mu_s=0.9, v_s=0.4)
    for t_end in (0.5, 20.0, 60.0):
        run = simulate(p, t_end=t_end, kernel="compiled")
        # The kernel counts as it runs; `complete_events` counts in the list of changes.
        events = complete_events(run.events, p, run.first_mode, run.changes, t_end)
        assert run.events.stick_time == pytest.approx(events.stick_time, abs=1e-12)
        assert run.events == events._replace(stick_time=run.events.stick_time)
        t, mode, next_mode = run.changes.T
        lifts_or_lands = (mode == Mode.SEPARATED) != (next_mode == Mode.SEPARATED)
        assert run.switch_times.tolist() == t[lifts_or_lands].tolist()


@kernels
@pytest.mark.parametrize(("speed", "peak"), [(1.0, 3.3446), (0.2, -0.05346)])
def test_on_a_slow_belt_the_peak_is_small_or_the_slider_stays_on_the_belt(
    speed: float, peak: float, kernel: KernelChoice
) -> None:
    run = simulate(Parameters(v_belt=speed), t_end=100.0, kernel=kernel)
    assert run.peak.y_max == pytest.approx(peak, rel=1e-4)
    assert (run.events.separations == 0) == (speed == 0.2)


def count_transitions(run: Transient) -> Counter[str]:
    return Counter(run.events.transitions)


@kernels
def test_every_transition_of_the_table_occurs(kernel: KernelChoice) -> None:
    # A slider that moves up and down on a belt at rest separates while it sticks.
    upright = UNIT_MASS.with_values({"v_belt": 0.0, "k_nl": 5.0})
    transitions = count_transitions(
        simulate(upright, t_end=20.0, start=(0, 0, -0.5, 3.0), kernel=kernel)
    )
    assert set(transitions) == {"separated-stick", "stick-separated"}
    scenes: tuple[tuple[dict[str, float], Start], ...] = (
        ({"v_belt": 1.0}, "static"),
        ({"v_belt": 0.5, "mu_s": 0.9, "v_s": 0.4}, (-2.0, -4.0, -1.0, 3.0)),
        ({"v_belt": 0.3, "mu": 0.2, "k3": 0.0}, (1.5, 5.0, -1.0, 4.0)),
        ({"v_belt": 0.0, "mu": 0.1, "F": 20.0}, (2.0, 5.0, -0.3, 4.0)),
    )
    for values, start in scenes:
        transitions += count_transitions(
            simulate(Parameters().with_values(values), t_end=30.0, start=start, kernel=kernel)
        )
    # CONTACT is the mode on a belt that is always faster, without `v_belt`.
    expected = {
        transition_name(mode, successor)
        for mode, row in MODES.items()
        for transition in row.ends
        for successor in transition.next_modes
        if Mode.CONTACT not in (mode, successor)
    }
    assert set(transitions) == expected


def smooth_intervals(run: Transient, first: float, end: float) -> Iterator[tuple[float, float]]:
    """Intervals of time in which friction changes little."""
    assert run.solution is not None
    parts = np.linspace(first, end, 2 + int((end - first) / 0.005))
    speeds, limit = run.solution(parts).vx, 0.5 * (run.parameters.v_s or np.inf)
    for (start, stop), change in zip(pairwise(parts), np.abs(np.diff(speeds)), strict=True):
        yield from pairwise(np.linspace(start, stop, 2 + int(change / limit)).tolist())


@kernels
@given(belts(), st.booleans())
@settings(max_examples=5)
@example(
    Parameters(
        m=1.0,
        k1=20.0,
        k2=20.0,
        k3=76.0,
        c1=0.0,
        c2=0.0,
        F=0.0,
        k_nl=0.0,
        mu=1.5,
        mu_s=2.0,
        v_s=0.25,
        v_belt=0.0,
    ),
    False,
)
def test_energy_changes_by_the_work_of_friction_and_damping(
    kernel: KernelChoice, p: Parameters, separation: bool
) -> None:
    # With separation ignored, only the cubic contact bounds a motion that grows.
    check_energy(p if separation else p.with_values({"k_nl": 20.0}), kernel, separation=separation)


@kernels
def test_energy_changes_by_friction_and_damping_also_in_runs_with_sticks_and_separations(
    kernel: KernelChoice,
) -> None:
    separations = 0
    for values in ({}, {"v_s": 0.4}, {"v_belt": 1.0, "F": 20.0}, {"v_belt": 0.0, "mu": 0.1}):
        p = Parameters(v_belt=0.5, mu_s=0.9).with_values(values)
        run = check_energy(p, kernel, separation=True, t_end=6.0)
        assert run.events.sticks > 1
        assert run.events.stick_time > 0.1
        separations += run.events.separations
    assert separations > 3


def check_energy(
    p: Parameters, kernel: KernelChoice, *, separation: bool, t_end: float = 3.0
) -> Transient:
    """Assert that the energy changes by the work of friction less the damping loss."""
    start: State = (0.3, 2.0, -0.4, 1.0)
    run = simulate(
        p,
        t_end=t_end,
        start=start,
        samples="dense",
        kernel=kernel,
        separation=separation,
        tol=1e-13,
    )
    assert run.solution is not None
    edges = sorted({0.0, *(change.t for change in run.mode_changes), t_end})
    nodes, weights = np.polynomial.legendre.leggauss(10)
    work = size = 0.0
    for first, end in pairwise(edges):
        for begin, stop in smooth_intervals(run, first, end):
            states = run.solution(begin + (stop - begin) * (0.5 + 0.5 * nodes))
            for n, weight in enumerate(weights.tolist()):
                state = (
                    float(states.x[n]),
                    float(states.vx[n]),
                    float(states.y[n]),
                    float(states.vy[n]),
                )
                friction_power, damping_power = power(p, state, Mode(int(states.mode[n])))
                work += 0.5 * (stop - begin) * weight * (friction_power - damping_power)
                size += 0.5 * (stop - begin) * weight * (abs(friction_power) + damping_power)
    _, *last_state = run.final
    x, vx, y, vy = last_state
    last_mode = run.mode_changes[-1].then if run.mode_changes else run.first_mode
    before = mechanical_energy(p, start, run.first_mode)
    after = mechanical_energy(p, (x, vx, y, vy), last_mode)
    assert after - before == pytest.approx(work, abs=1e-7 * (size + abs(before) + 1.0))
    return run


@kernels
@given(belts(), st.booleans(), st.floats(0.0, 2.0))
@settings(max_examples=20)
def test_states_satisfy_the_conditions_of_their_mode(
    kernel: KernelChoice, p: Parameters, separation: bool, push: float
) -> None:
    p = p.with_values({"k_nl": max(p.k_nl, 20.0)})
    run = simulate(
        p,
        t_end=5.0,
        start=(push, p.v_belt or 0.0, -push, push),
        samples=400,
        kernel=kernel,
        separation=separation,
    )
    motion = run.to_columns()
    mode, sliding_speed = motion["mode"], (p.v_belt or 0.0) - motion["vx"]
    tolerance = 1e-9 * (1.0 + np.abs(motion["vx"]).max())
    assert np.all(sliding_speed[mode == Mode.FORWARD] >= -tolerance)
    assert np.all(sliding_speed[mode == Mode.BACKWARD] <= tolerance)
    assert np.all(np.abs(sliding_speed[mode == Mode.STICK]) <= tolerance)
    assert np.all(motion["y"][mode == Mode.SEPARATED] >= -tolerance)
    if separation:
        assert np.all(motion["y"][mode != Mode.SEPARATED] <= tolerance)
    spring_force = (
        p.c1 * (p.v_belt or 0.0) + (p.k1 + 0.5 * p.k3) * motion["x"] - 0.5 * p.k3 * motion["y"]
    )
    grip = p.mu_static * motion["P"] - np.abs(spring_force)
    assert np.all(grip[mode == Mode.STICK] >= -1e-7 * (1.0 + np.abs(spring_force).max()))


@kernels
def test_a_slider_at_rest_on_a_belt_at_rest_stays_where_it_is(kernel: KernelChoice) -> None:
    run = simulate(Parameters(v_belt=0.0), t_end=1e3, kernel=kernel)
    assert run.events.transitions == {}
    assert (run.events.sticks, run.events.stick_time) == (1, 1e3)
    assert run.peak.y_max - run.peak.y_min < 1e-12


def test_a_sliding_speed_below_zero_by_rounding_gives_a_step_of_finite_length() -> None:
    p = Parameters(v_belt=1.0 - 1e-16, mu_s=0.9, v_s=1e-12)
    segment = BeltStepper(System(p), (0.0, 1.0, -1.0, 0.0)).advance()
    assert segment.duration > 0.0
    # Friction falls as exp(-v/v_s): for a speed v below zero the exponent is limited.
    assert math.isfinite(exponential(1e6))

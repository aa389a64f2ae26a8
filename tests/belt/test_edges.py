"""Where modes meet: touches of a guard, several guards at once, balanced forces, a stick for ever.

A guard is a function of the state that is positive while a mode lasts. A step on a falling friction
law that is shorter than `UNRESOLVED` times t counts as stalled. `UNIT_MASS` is a mass without
coupling with m, k1, k2 and F of 1, mu = 0.5 and mu_s = 1.
"""

import math

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.kernel import Status, load_kernel
from fivtui.model import System, static_start
from fivtui.model.errors import ComputationError
from fivtui.model.modes import Mode
from fivtui.taylor.belt import UNRESOLVED
from fivtui.taylor.stepper import MAX_STALLED
from fivtui.transient.request import KernelChoice
from tests.support.independent_belt import IndependentBelt, integrate

from .test_motion import UNIT_MASS

kernels = pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
# Factors just below and just above a critical value.
JUST_BELOW, JUST_ABOVE = 1.0 - 1e-9, 1.0 + 1e-9


@kernels
def test_a_slider_just_slower_than_the_belt_slides_on_and_one_just_faster_sticks(
    kernel: KernelChoice,
) -> None:
    # The slider oscillates about x = mu P/k1 with a peak speed of 0.3 m/s.
    for v_belt, sticks in ((0.3 * JUST_ABOVE, 0), (0.3 * JUST_BELOW, 1)):
        p = UNIT_MASS.with_values({"v_belt": v_belt})
        run = simulate(p, t_end=6.0, start=(0.2, 0.0, -1.0, 0.0), kernel=kernel)
        assert run.events.sticks == sticks
        if sticks:
            first = run.mode_changes[0]
            assert (first.first, first.then) == (Mode.FORWARD, Mode.STICK)
            assert first.t == pytest.approx(0.5 * math.pi, abs=1e-4)
        else:
            x = 0.5 - 0.3 * math.cos(6.0)
            assert run.final[1:3] == pytest.approx((x, 0.3 * math.sin(6.0)), abs=1e-12)


@kernels
def test_a_belt_exactly_as_fast_as_the_slider_gives_the_motion_of_a_slightly_slower_or_faster_one(
    kernel: KernelChoice,
) -> None:
    final_states = []
    for factor in (JUST_BELOW, 1.0, JUST_ABOVE):
        p = UNIT_MASS.with_values({"v_belt": 0.3 * factor})
        final_states.append(
            simulate(p, t_end=6.0, start=(0.2, 0.0, -1.0, 0.0), kernel=kernel).final[1:]
        )
    slow, equal, fast = (np.array(end) for end in final_states)
    assert min(np.abs(equal - slow).max(), np.abs(equal - fast).max()) < 1e-3
    assert np.abs(slow - fast).max() > 0.01


@kernels
def test_friction_just_above_the_holding_force_holds_and_just_below_it_slips(
    kernel: KernelChoice,
) -> None:
    # P = 1 + 0.2 cos t is least at t = π: 0.8 N, the limit of static friction for mu_s = 1.
    for factor, sticks in ((JUST_BELOW, True), (JUST_ABOVE, False)):
        p = UNIT_MASS.with_values({"v_belt": 0.0})
        start = (0.8 * factor, 0.0, -1.2, 0.0)
        run = simulate(p, t_end=20.0, start=start, kernel=kernel)
        assert run.first_mode is Mode.STICK
        assert (run.events.stick_time == 20.0) is sticks
        if not sticks:
            assert run.mode_changes[0].then is Mode.FORWARD
            assert run.mode_changes[0].t == pytest.approx(math.pi, abs=1e-3)


@kernels
def test_a_spring_force_equal_to_the_static_friction_is_held_for_ever(kernel: KernelChoice) -> None:
    for x in (1.0, -1.0):
        p = UNIT_MASS.with_values({"v_belt": 0.0})
        run = simulate(p, t_end=50.0, start=(x, 0.0, -1.0, 0.0), kernel=kernel)
        assert run.events.transitions == {}
        assert run.events.stick_time == 50.0
        assert run.final[1:] == (x, 0.0, -1.0, 0.0)


@kernels
def test_an_oscillation_on_a_belt_at_rest_is_damped_by_friction_as_in_closed_form(
    kernel: KernelChoice,
) -> None:
    # Coulomb damping: each half cycle reduces the amplitude by 2 mu P/k1, until the slider sticks.
    p = UNIT_MASS.with_values({"v_belt": 0.0, "mu": 0.1, "mu_s": 0.1})
    run = simulate(p, t_end=100.0, start=(1.03, 0.0, -1.0, 0.0), kernel=kernel)
    assert run.events.transitions == {
        "forward-backward": 2,
        "backward-forward": 2,
        "forward-stick": 1,
    }
    assert [change.t for change in run.mode_changes] == pytest.approx(
        [n * math.pi for n in range(1, 6)], abs=1e-12
    )
    assert run.final[1:] == pytest.approx((-0.03, 0.0, -1.0, 0.0), abs=1e-12)


@kernels
def test_a_slider_that_lifts_off_as_it_reaches_the_speed_of_the_belt_separates(
    kernel: KernelChoice,
) -> None:
    # The belt has the slider's speed at its first lift-off, from a run on an always faster belt.
    p = Parameters(k1=20.0, k3=0.0, mu=0.4)
    start = (-5.0, 1.0, -1.5, 0.0)
    fast_run = simulate(p.with_values({"v_belt": 1e3}), t_end=1.5, start=start, samples="dense")
    assert fast_run.solution is not None
    lift_off_time = float(fast_run.switch_times[0])
    speed = float(fast_run.solution(np.array([lift_off_time])).vx[0])
    vx_before = fast_run.solution(np.linspace(0.0, lift_off_time, 2001)[:-1]).vx.max()
    assert vx_before < speed
    final_states = []
    for value in (speed, math.nextafter(speed, 0.0), speed * (1.0 - 1e-13), speed * (1.0 + 1e-13)):
        run = simulate(
            p.with_values({"v_belt": value, "mu_s": 0.9}), t_end=1.5, start=start, kernel=kernel
        )
        assert Mode.SEPARATED in [change.then for change in run.mode_changes[:3]]
        assert run.switch_times[0] == pytest.approx(lift_off_time, abs=1e-9)
        final_states.append(run.final[1:])
    assert np.ptp(np.array(final_states), axis=0).max() < 1e-8


@kernels
@pytest.mark.parametrize("start", [(0.4, -1.0), (-0.4, -1.0), (0.0, -1.0), (0.4, 1.0), (0.4, 0.0)])
def test_after_landing_at_the_speed_of_the_belt_the_holding_force_determines_the_slip(
    kernel: KernelChoice, start: tuple[float, float]
) -> None:
    v_belt, (x, vy) = 0.5, start
    p = Parameters(v_belt=v_belt, mu_s=0.9, k3=20.0)
    start_state = (x, v_belt, 0.0, vy)
    run = simulate(p, t_end=1.0, start=start_state, kernel=kernel)
    if vy > 0.0:
        assert run.first_mode is Mode.SEPARATED
        return
    # The spring k3 at 45° acts along x with half of its stiffness.
    holding_force = p.c1 * v_belt + (p.k1 + 0.5 * p.k3) * x
    assert run.first_mode is (Mode.FORWARD if holding_force > 0.0 else Mode.BACKWARD)
    state, modes = integrate(IndependentBelt(p), np.array(start_state), 1.0)
    mode_sequence = [run.first_mode, *(change.then for change in run.mode_changes)]
    assert [mode.name.lower() for mode in mode_sequence] == modes
    assert run.final[1:] == pytest.approx(state.tolist(), rel=1e-8, abs=1e-8)


@kernels
def test_in_tension_the_slider_passes_the_speed_of_the_belt_without_a_stick(
    kernel: KernelChoice,
) -> None:
    p = Parameters(v_belt=0.5, k_nl=0.0, F=5.0, mu_s=5.0)
    run = simulate(
        p, t_end=6.0, start=(0.5, 0.0, 1.0, 2.0), separation=False, samples=6001, kernel=kernel
    )
    motion = run.to_columns()
    assert run.events.sticks > 0
    assert np.all(motion["P"][motion["mode"] == Mode.STICK] >= 0.0)
    assert np.any(motion["P"] < 0.0)
    assert {"forward-backward", "backward-forward"} & run.events.transitions.keys()


# The least mass and velocity scale of friction in range, on the stiffest contact.
UNRESOLVED_LAW = {"v_s": 1e-12, "m": 1e-12, "k2": 1e12}


@kernels
def test_a_friction_law_too_sharp_for_double_precision_is_refused_with_advice(
    kernel: KernelChoice,
) -> None:
    p = Parameters(v_belt=1.0, mu_s=0.9)
    with pytest.raises(ComputationError, match=r"faster than .* resolve.*larger v_s") as caught:
        simulate(p.with_values(UNRESOLVED_LAW), t_end=20.0, kernel=kernel)
    assert "grows" not in caught.value.why
    # For small v_s the law converges to friction that drops at once.
    sharp_law = simulate(p.with_values({"v_s": 1e-12}), t_end=20.0, kernel="compiled")
    sudden_drop = simulate(p, t_end=20.0, kernel="compiled")
    assert sharp_law.final == pytest.approx(sudden_drop.final, abs=1e-7)
    assert sharp_law.events.transitions == sudden_drop.events.transitions


def stalled_step_lengths(p: Parameters, v_s: float) -> list[float]:
    """Lengths of the steps of a run that ends because its steps do not advance it.

    `v_s` replaces that of `p`. It is below its range: parameters in range never have so many
    stalled steps.
    """
    start = static_start(System(p))
    belt = (p.v_belt or 0.0, p.mu_static, v_s)
    step_lengths: list[float] = []
    run = load_kernel().begin_run(
        p.values(), start, separation=True, t_end=1e3, tol=1e-9, order=12, belt=belt
    )
    t, status = 0.0, Status.RUNNING
    while status is Status.RUNNING:
        status = run.advance(1)
        step_lengths.append(run.outcome.t - t)
        t = run.outcome.t
    assert status is Status.STALLED
    return step_lengths


def test_a_run_ends_after_the_greatest_number_of_stalled_steps() -> None:
    step_lengths = np.array(stalled_step_lengths(Parameters(v_belt=1.0, mu_s=0.9), v_s=1e-17))
    is_stalled = step_lengths < UNRESOLVED * np.cumsum(step_lengths)
    # The run ends by the first stalled step beyond the greatest number.
    stalled_count = MAX_STALLED + 1
    assert np.all(is_stalled[-stalled_count:])
    assert not is_stalled[-stalled_count - 1]


@pytest.mark.parametrize("separation", [True, False])
def test_every_belt_faster_than_the_slider_gives_the_bits_of_a_belt_that_is_always_faster(
    separation: bool,
) -> None:
    for values in ({}, {"F": 30.0, "k3": 0.0}, {"F": 120.0, "k_nl": 500.0, "c1": 1.0}):
        p = Parameters().with_values(values)
        fast_run = simulate(p, t_end=20.0, separation=separation)
        for speed in (fast_run.peak.vx_max * (1.0 + 1e-15) + 1e-300, 100.0, 1e9):
            run = simulate(
                p.with_values({"v_belt": speed, "mu_s": 2.0}), t_end=20.0, separation=separation
            )
            for name in ("final", "peak", "steady", "contact_force"):
                assert getattr(run, name) == getattr(fast_run, name)
            assert run.switch_times.tolist() == fast_run.switch_times.tolist()
            assert run.stats.steps == fast_run.stats.steps

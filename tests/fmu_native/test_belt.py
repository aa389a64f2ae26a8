"""The native FMU on a belt of finite speed: model exchange, derivatives, ramps, and events.

Results of `simulate`, which runs the kernel without an FMU, are named `direct`. `fmu` is the FMU as
a file, which fmpy runs; `folder` has its extracted files.
"""

import itertools
from pathlib import Path
from typing import Any, Final

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fivtui import Parameters, simulate
from fivtui.model import Mode, State, build_course, friction_force
from fivtui.model.field import Rates
from tests.support.fmu_exchange import (
    INDICATORS,
    integrate_instance,
    model_exchange_instance,
    read,
    write_states,
)
from tests.support.fmu_instance import FmuInstance

# Order of the continuous states in the FMU.
ORDER: Final = ("x", "y", "vx", "vy")
STATES: Final = ("x", "vx", "y", "vy")
COUNTS: Final = ("separations", "reattachments", "switches", "sticks", "mode")
# Parameters with which a run from START visits all modes. Friction falls from the coefficient mu_s
# at rest to mu as the sliding speed exceeds v_s, m/s.
ALL_MODES: Final = Parameters(v_belt=2.0, mu_s=0.8, v_s=0.4)
START: Final[State] = (2.0, 8.0, 1.0, 0.0)
# Parameters and start of each scene; without a start, the equilibrium for mu = 0. In the last
# scene the slider starts at the belt's speed, but static friction cannot hold it.
SCENES: Final = {
    "stick-slip": (Parameters(v_belt=1.0), None),
    "all modes": (ALL_MODES, START),
    "slip at once": (Parameters(v_belt=0.0, mu_s=0.8), (0.5, 0.0, -0.4, 4.0)),
}


def start_values(p: Parameters, start: State | None) -> dict[str, float | bool]:
    values: dict[str, float | bool] = {**p.as_dict(), "finite_belt": True}
    if start is not None:
        values["start_static"] = False
        values |= {f"{n}_start": x for n, x in zip(STATES, start, strict=True)}
    return values


@pytest.mark.parametrize("scene", SCENES)
# Delay, s, with which the importer handles each event, and the allowed error of the final state.
@pytest.mark.parametrize(("delay", "error"), [(0.0, 1e-8), (1e-9, 1e-6)])
def test_an_importer_finds_the_mode_changes_of_a_direct_run(
    folder: Path, scene: str, delay: float, error: float
) -> None:
    p, start = SCENES[scene]
    direct = simulate(p, t_end=4.0, start=start or "static")
    with model_exchange_instance(folder, **start_values(p, start)) as instance:
        state = integrate_instance(instance, 4.0, late=delay)
        *counts, final_mode = instance.get(*COUNTS)
        event_time = instance.get("last_event")
    events, final = direct.events, direct.final
    assert state == pytest.approx([final.x, final.y, final.vx, final.vy], abs=error)
    switches = sum(events.transitions.values())
    assert counts == [events.separations, events.reattachments, switches, events.sticks]
    assert final_mode == direct.mode_changes[-1].then
    assert event_time == pytest.approx([direct.mode_changes[-1].t], abs=1e-8)


def test_cvode_finds_the_mode_changes_of_a_direct_run(fmu: Path) -> None:
    direct = simulate(ALL_MODES, t_end=5.0, start=START)
    run = fmpy.simulate_fmu(
        str(fmu),
        stop_time=5.0,
        output_interval=0.05,
        relative_tolerance=1e-9,
        fmi_type="ModelExchange",
        start_values=start_values(ALL_MODES, START),
    )
    assert run["switches"][-1] == sum(direct.events.transitions.values())
    assert run["sticks"][-1] == direct.events.sticks
    assert (run["x"][-1], run["y"][-1]) == pytest.approx((direct.final.x, direct.final.y), abs=1e-5)


def set_states(
    instance: FmuInstance, x: float, vx: float, y: float, vy: float
) -> tuple[float, list[float]]:
    """Set the states and handle an event; return the new mode and the event indicators."""
    write_states(instance.fmi, np.array([x, y, vx, vy]))
    instance.fmi.enterEventMode()
    instance.update_mode()
    instance.fmi.enterContinuousTimeMode()
    (mode,) = instance.get("mode")
    return mode, read(instance.fmi.getEventIndicators, INDICATORS)


def set_states_for_mode(instance: FmuInstance, x: float, vx: float, y: float, vy: float) -> float:
    """Set the states and handle an event; return the new mode."""
    mode, _ = set_states(instance, x, vx, y, vy)
    return mode


def test_event_indicators_are_those_of_the_events_that_end_the_mode(folder: Path) -> None:
    # The indicators are y, the sliding speed v_r = v_belt − vx, and in stick the distances of the
    # friction force f from the limits ±mu_s P. Those that do not end the mode are 1.
    with model_exchange_instance(folder, **start_values(ALL_MODES, START)) as instance:
        assert set_states(instance, 0.0, 1.5, -0.5, 0.1) == (Mode.FORWARD, [-0.5, 0.5, 1.0, 1.0])
        assert set_states(instance, 0.0, 2.5, -0.5, 0.1) == (Mode.BACKWARD, [-0.5, -0.5, 1.0, 1.0])
        assert set_states(instance, 0.0, 2.5, 0.5, 0.1) == (Mode.SEPARATED, [0.5, 1.0, 1.0, 1.0])
        vx, y = 2.0, -0.5
        stick_mode, indicators = set_states(instance, 0.0, vx, y, 0.1)
        assert stick_mode == Mode.STICK
        contact_force = -ALL_MODES.k2 * y - ALL_MODES.k_nl * y**3
        limit = 0.8 * contact_force
        # The force that holds the slider at x = 0 against the damper c1 and the spring k3, which
        # acts along x with half of its stiffness.
        f = ALL_MODES.c1 * vx - 0.5 * ALL_MODES.k3 * y
        assert indicators == pytest.approx([y, 1.0, limit - f, limit + f])
        # v_r is zero to rounding, but to hold the slider at these x takes f = 54.6 N and −49.4 N,
        # beyond the limits ±30 N: it slips.
        for x, mode in ((0.3, Mode.FORWARD), (-0.5, Mode.BACKWARD)):
            slip_mode, (height, v_r, *_) = set_states(instance, x, 2.0 + 1e-12, -0.5, 0.1)
            assert (slip_mode, height) == (mode, -0.5)
            # The FMU sets vx to v_belt. The indicator v_r is not zero, but the smallest number of
            # the sign that v_r has in the new mode: the importer finds no event at its start.
            assert instance.get("vx") == [2.0]
            assert v_r == (1 if mode is Mode.FORWARD else -1) * np.finfo(float).tiny


@pytest.mark.parametrize(
    ("mode", "first_vx", "vx", "expected"),
    [
        # Past v_r = 0 within the error of a low tolerance: v is set to the belt's speed.
        (Mode.FORWARD, 1.5, 2.01, (Mode.STICK, 2.0)),
        (Mode.BACKWARD, 2.5, 1.99, (Mode.STICK, 2.0)),
        # Equally close to v_r = 0, but v_r has the sign of the mode: the slider keeps sliding.
        (Mode.FORWARD, 1.5, 1.99, (Mode.FORWARD, 1.99)),
        (Mode.BACKWARD, 2.5, 2.01, (Mode.BACKWARD, 2.01)),
        # Far past v_r = 0: the importer set the state, so it is kept.
        (Mode.FORWARD, 1.5, 2.2, (Mode.BACKWARD, 2.2)),
        (Mode.BACKWARD, 2.5, 1.8, (Mode.FORWARD, 1.8)),
        # From stick the sign of v_r decides the new mode.
        (Mode.STICK, 2.0, 2.01, (Mode.BACKWARD, 2.01)),
        (Mode.STICK, 2.0, 1.99, (Mode.FORWARD, 1.99)),
    ],
)
def test_a_sliding_slider_slightly_past_the_belt_speed_sticks_at_that_speed(
    folder: Path, mode: Mode, first_vx: float, vx: float, expected: tuple[Mode, float]
) -> None:
    # Static friction would hold the slider in this state.
    with model_exchange_instance(folder, **start_values(ALL_MODES, START)) as instance:
        assert set_states_for_mode(instance, 0.0, first_vx, -0.5, 0.1) == mode
        expected_mode, expected_vx = expected
        assert set_states_for_mode(instance, 0.0, vx, -0.5, 0.1) == expected_mode
        assert instance.get("vx") == [expected_vx]


@pytest.mark.parametrize(
    ("mode", "vx", "speed"), [("FORWARD", 1.99, 1.98), ("BACKWARD", 2.01, 2.02)]
)
def test_a_belt_speed_that_passes_the_slider_leaves_the_velocity_unchanged(
    folder: Path, mode: str, vx: float, speed: float
) -> None:
    opposite = Mode.BACKWARD if mode == "FORWARD" else Mode.FORWARD
    with model_exchange_instance(folder, **start_values(ALL_MODES, START)) as instance:
        assert set_states_for_mode(instance, 0.0, vx, -0.5, 0.1) == Mode[mode]
        instance.fmi.enterEventMode()
        instance.set(v_belt=speed)
        assert instance.update_mode()
        assert instance.get("mode", "vx") == [opposite, vx]


def test_without_a_finite_belt_its_event_indicators_stay_at_one(folder: Path) -> None:
    with model_exchange_instance(folder) as instance:
        assert read(instance.fmi.getEventIndicators, INDICATORS)[1:] == [1.0, 1.0, 1.0]


def test_the_belt_speed_may_change_during_stick_only_in_event_mode(folder: Path) -> None:
    with model_exchange_instance(folder, **start_values(ALL_MODES, START)) as instance:
        fmi = instance.fmi
        assert set_states_for_mode(instance, 0.0, 2.0, -0.5, 0.1) == Mode.STICK
        # Setting the present value is no change.
        instance.set(v_belt=2.0)
        with pytest.raises(FMICallException, match="discard"):
            instance.set(v_belt=2.1)
        assert "must stay 2 while the slider sticks, except in event mode" in instance.log[-1]
        assert instance.get("v_belt", "mode") == [2.0, Mode.STICK]
        fmi.enterEventMode()
        instance.set(v_belt=2.1)
        assert instance.update_mode()
        assert instance.get("mode", "vx") == [Mode.FORWARD, 2.0]
        fmi.enterContinuousTimeMode()
        instance.set(v_belt=2.2)
        assert instance.get("v_belt") == [2.2]


# "switching" is y, whose sign tells contact from separation.
UNKNOWNS: Final = ("vx", "vy", "ax", "ay", "P", "friction_slider", "friction_belt", "switching")
KNOWNS: Final = (*ORDER, "F", "mu", "v_belt")
STATES_BY_MODE: Final[dict[Mode, State]] = {
    Mode.SEPARATED: (0.1, 1.5, 0.5, 0.1),
    Mode.FORWARD: (0.1, 1.5, -0.5, 0.1),
    Mode.BACKWARD: (0.1, 2.3, -0.5, 0.1),
    Mode.STICK: (0.1, 2.0, -0.5, 0.1),
}


@pytest.mark.parametrize("mode", STATES_BY_MODE)
def test_directional_derivatives_agree_with_differences_in_every_mode(
    folder: Path, mode: Mode
) -> None:
    x, vx, y, vy = STATES_BY_MODE[mode]
    # Values of KNOWNS: states and inputs.
    base_values = np.array([x, y, vx, vy, 80.0, 0.7, 2.0])

    with model_exchange_instance(folder, **start_values(ALL_MODES, START)) as instance:
        assert set_states_for_mode(instance, x, vx, y, vy) == mode
        references = [[instance.references[n] for n in names] for names in (UNKNOWNS, KNOWNS)]
        rng = np.random.default_rng(1)

        def set_known_values(values: Any) -> None:
            states, (F, mu, speed) = np.split(values, [len(ORDER)])
            write_states(instance.fmi, states)
            # Event mode, because v_belt is fixed while the slider sticks. Without an update the
            # mode stays.
            instance.fmi.enterEventMode()
            instance.set(F=F, mu=mu, v_belt=speed)
            instance.fmi.enterContinuousTimeMode()

        def outputs_at(values: Any) -> Any:
            set_known_values(values)
            return np.array(instance.get(*UNKNOWNS))

        # Each known variable alone, then all of them together.
        for direction in (*np.eye(len(KNOWNS)), rng.normal(size=len(KNOWNS))):
            shift = 1e-5 * direction
            difference = (outputs_at(base_values + shift) - outputs_at(base_values - shift)) / 2e-5
            set_known_values(base_values)
            exact = instance.fmi.getDirectionalDerivative(*references, direction.tolist())
            assert exact == pytest.approx(difference, rel=1e-6, abs=1e-6)


def friction_and_acceleration(p: Parameters, state: State, mode: Mode) -> list[float]:
    """Friction on the slider and horizontal acceleration from the equations of motion."""
    x, vx, y, _ = state
    friction = friction_force(p, state, mode)
    pull = p.c1 * vx + p.k1 * x + 0.5 * p.k3 * (x - y)
    return [friction, 0.0 if mode is Mode.STICK else (friction - pull) / p.m]


@pytest.mark.parametrize("mode", STATES_BY_MODE)
def test_derivatives_with_respect_to_parameters_agree_with_the_equations(
    folder: Path, mode: Mode
) -> None:
    state = STATES_BY_MODE[mode]
    starts = start_values(ALL_MODES, state)
    with FmuInstance(folder).begin(**starts) as instance:
        unknowns = [instance.references[name] for name in ("friction_slider", "ax")]
        # Mass, springs, damper, cubic contact stiffness, and the law of friction.
        for name in ("m", "k1", "k2", "k3", "c1", "k_nl", "mu_s", "v_s"):
            h = 1e-5 * getattr(ALL_MODES, name)
            shifted_values = [
                friction_and_acceleration(
                    ALL_MODES.with_values({name: getattr(ALL_MODES, name) + sign * h}), state, mode
                )
                for sign in (1.0, -1.0)
            ]
            difference = [
                (high - low) / (2.0 * h) for high, low in zip(*shifted_values, strict=True)
            ]
            exact = instance.fmi.getDirectionalDerivative(
                unknowns, [instance.references[name]], [1.0]
            )
            assert exact == pytest.approx(difference, rel=1e-6, abs=1e-6), name


def test_static_friction_that_equals_mu_has_no_derivative(folder: Path) -> None:
    # mu_s is not set: static friction equals mu, so a small change of mu_s has no meaning.
    values = start_values(ALL_MODES.with_values({"mu_s": None}), STATES_BY_MODE[Mode.FORWARD])
    with FmuInstance(folder).begin(**values) as instance:
        references = [[instance.references[n]] for n in ("friction_slider", "mu_s")]
        with pytest.raises(FMICallException, match="discard"):
            instance.fmi.getDirectionalDerivative(*references, [1.0])
        assert "the derivative of friction_slider is not a finite number" in instance.log[-1]


# Points (time in s, value) of each input; a repeated time is a jump.
TABLES: Final[dict[str, list[tuple[float, float]]]] = {
    "F": [(0, 40), (4, 100), (8, 60)],
    "mu": [(0, 0.7), (2, 0.7), (6, 0.5), (6, 0.8)],
    "v_belt": [(0, 3), (1, 3), (5, 1), (5, 2), (9, 0)],
}


@pytest.mark.parametrize("step", [1.0, 0.25])
@pytest.mark.parametrize("settings", [{}, {"mu_s": 0.9, "v_s": 0.4}])
def test_input_ramps_give_the_motion_of_tables_in_a_direct_run(
    folder: Path, step: float, settings: dict[str, float]
) -> None:
    parameters = Parameters(**settings)
    # The parameters as functions of time: TABLES give v_belt, F and mu.
    course = build_course(parameters, TABLES)
    p, _ = course.after(0.0)
    records = []
    with FmuInstance(folder).begin(**start_values(p, None)) as instance:
        while instance.t < 10.0:
            p, rates = course.after(instance.t)
            assert p.v_belt is not None
            instance.set(F=p.F, mu=p.mu, v_belt=p.v_belt)
            instance.set_slopes(F=rates.F, mu=rates.mu, v_belt=rates.v_belt)
            records.append((p, rates, instance.get(*STATES, "mode", "friction_slider", "ax")))
            instance.step(step)
        state = instance.get(*STATES)
        counts = instance.get("separations", "switches", "sticks", "mode")
    direct = simulate(parameters, t_end=10.0, over_time=TABLES)
    events = direct.events
    direct_counts = [events.separations, sum(events.transitions.values()), events.sticks]
    final = direct.final
    assert state == pytest.approx([final.x, final.vx, final.y, final.vy], abs=1e-9)
    assert counts == [*direct_counts, direct.mode_changes[-1].then]
    assert min(direct_counts) > 0
    modes = set()
    for p, rates, (x, vx, y, vy, mode_number, friction, ax) in records:
        mode = Mode(int(mode_number))
        modes.add(mode)
        assert friction == pytest.approx(friction_force(p, (x, vx, y, vy), mode, rates), abs=1e-9)
        assert mode is not Mode.STICK or ax == rates.v_belt
    assert Mode.STICK in modes


def test_a_ramp_of_the_belt_speed_adds_to_friction_until_a_new_input_is_set(folder: Path) -> None:
    p = Parameters(v_belt=0.5, mu_s=0.9)
    start: State = (0.0, 0.5, -1.0, 0.0)
    with FmuInstance(folder).begin(**start_values(p, start)) as instance:
        assert instance.get("mode", "sticks", "switches") == [Mode.STICK, 1.0, 0.0]
        instance.set_slopes(v_belt=-0.5)
        instance.step(0.125)
        x, vx, y, vy, mode, friction, ax = instance.get(*STATES, "mode", "friction_slider", "ax")
        assert (mode, ax) == (Mode.STICK, -0.5)
        assert vx == pytest.approx(0.4375, abs=1e-15)
        # In stick, friction also accelerates the slider with the belt: it includes m times the
        # slope of v_belt, at the end of the step too.
        held_parameters = p.with_values({"v_belt": 0.4375})
        state = (x, vx, y, vy)
        on_ramp = friction_force(held_parameters, state, Mode.STICK, Rates(v_belt=-0.5))
        assert friction == pytest.approx(on_ramp, rel=1e-12)
        # Once an input is set, friction is that of the next step, in which the belt has a constant
        # speed. The input here is F, which does not change friction in stick.
        instance.set_slopes(v_belt=0.0)
        instance.set(F=81.0)
        assert instance.get("friction_slider") == pytest.approx(
            [friction_force(held_parameters, state, Mode.STICK)], rel=1e-12
        )


def test_a_ramp_of_friction_above_static_friction_is_refused(folder: Path) -> None:
    with FmuInstance(folder).begin(**start_values(ALL_MODES, START)) as instance:
        instance.set_slopes(mu=0.2)
        with pytest.raises(FMICallException, match="discard"):
            instance.step(1.0)
        assert "mu = 0.9: must be at most mu_s = 0.8" in instance.log[-1]
        instance.step(0.25)
        assert instance.get("mu") == pytest.approx([0.75])
        instance.set_slopes(v_belt=-2e9)
        with pytest.raises(FMICallException, match="discard"):
            instance.step(1.0)
        assert "v_belt = -2e+09 at the end of the step: must be from -1e+09" in instance.log[-1]


def test_a_state_saved_on_a_ramp_in_stick_continues_with_the_same_bits(folder: Path) -> None:
    p = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4)
    names = [*STATES, "mode", "switches", "sticks", "last_event", "friction_slider"]
    with (
        FmuInstance(folder).begin(**start_values(p, None)) as source,
        FmuInstance(folder).begin() as restored,
    ):
        for number in range(40):
            source.set_slopes(v_belt=0.2 if number % 2 else -0.2, F=3.0 if number % 2 else -3.0)
            saved = source.fmi.getFMUstate()
            copy = restored.fmi.deSerializeFMUstate(source.fmi.serializeFMUstate(saved))
            restored.fmi.setFMUstate(copy)
            restored.t = source.t
            for instance in (source, restored):
                instance.step(0.05)
            assert source.get(*names) == restored.get(*names)
            restored.fmi.freeFMUstate(copy)
            source.fmi.freeFMUstate(saved)
        (sticks,) = source.get("sticks")
        assert sticks > 1.0


def test_the_step_size_does_not_change_the_bits_of_the_results(folder: Path) -> None:
    final_outputs = []
    for h in (2.0**-10, 2.0**-5, 1.0):
        with FmuInstance(folder).begin(**start_values(ALL_MODES, START)) as instance:
            for _ in range(round(4.0 / h)):
                instance.step(h)
            final_outputs.append(instance.get(*STATES, *COUNTS, "last_event", "friction_slider"))
    for first, second in itertools.pairwise(final_outputs):
        assert first == second

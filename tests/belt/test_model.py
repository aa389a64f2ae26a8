"""Tests of the table of modes, and of the model on a belt of finite speed."""

import math

import pytest
from hypothesis import given, strategies as st

from fivtui import Parameters, simulate
from fivtui.model.errors import InputError
from fivtui.model.field import exponential, friction_coefficient, guard_value
from fivtui.model.modes import MODES, Guard, Mode
from fivtui.model.slider_belt import MIN_FORCE, State, accelerations, friction_force, mode_of
from fivtui.transient.request import KernelChoice
from tests.support.strategies import moderate_parameters, states

SLIDING = (Mode.FORWARD, Mode.BACKWARD)


@st.composite
def belts(draw: st.DrawFn) -> Parameters:
    speed_scale = draw(st.one_of(st.none(), st.floats(0.05, 2.0)))
    p = draw(moderate_parameters())
    v_belt = draw(st.floats(0.0, 5.0))
    mu_s = p.mu + draw(st.floats(0.0, 0.5))
    return p.with_values({"v_belt": v_belt, "mu_s": mu_s, "v_s": speed_scale})


def test_belt_parameters_are_none_or_within_bounds() -> None:
    # `mu_static` is mu_s, or mu without it; `speed_law` is v_s, or None if friction is constant.
    base = Parameters()
    assert (base.v_belt, base.mu_static, base.speed_law) == (None, base.mu, None)
    p = Parameters().with_values({"v_belt": "1", "mu_s": "0.9", "v_s": "0.4"})
    assert (p.v_belt, p.mu_static, p.speed_law) == (1.0, 0.9, 0.4)
    assert Parameters(**p.as_dict()) == p
    assert p.with_values({"v_belt": "none", "mu_s": None, "v_s": "none"}) == Parameters()
    assert list(Parameters(v_belt=0.0).as_dict())[-1] == "v_belt"
    for name, text in (("v_belt", "-2e9"), ("v_s", "0"), ("mu_s", "nan"), ("v_belt", "None")):
        with pytest.raises(InputError, match=rf"^{name} = .*must be none, or "):
            Parameters().with_values({name: text})
    with pytest.raises(InputError, match=r"^mu_s = 0\.5: must be none, or at least mu = 0\.7$"):
        Parameters(mu_s=0.5)
    with pytest.raises(InputError, match=r"^F = 'none'"):
        Parameters().with_values({"F": "none"})


def test_modes_end_in_other_modes_of_the_same_kind_of_belt_or_in_separation() -> None:
    for mode, row in MODES.items():
        for transition in row.ends:
            assert mode not in transition.next_modes
            for successor in transition.next_modes:
                finite_belts = {row.finite_belt, MODES[successor].finite_belt}
                assert finite_belts != {True, False} or Mode.SEPARATED in (mode, successor)


@given(belts(), states())
def test_a_mode_begins_where_its_guards_are_positive(p: Parameters, state: State) -> None:
    mode = mode_of(p, state, separation=True)
    for transition in MODES[mode].ends:
        assert guard_value(p, state, transition.guard) >= -1e-12 * p.mu_static * p.F


@given(belts(), states())
def test_at_the_speed_of_the_belt_the_acceleration_determines_the_mode(
    p: Parameters, state: State
) -> None:
    x, _, y, vy = state
    state_at_belt_speed = (x, p.v_belt or 0.0, y, vy)
    mode = mode_of(p, state_at_belt_speed, separation=False)
    if mode is Mode.STICK:
        spring_force = abs(friction_force(p, state_at_belt_speed, Mode.STICK))
        grip = p.mu_static * max(-p.k2 * y - p.k_nl * y**3, 0.0)
        assert spring_force <= grip + 1e-12 * (spring_force + grip + p.mu_static * p.F) + MIN_FORCE
        assert accelerations(p, state_at_belt_speed, mode)[0] == 0.0
    else:
        ax = accelerations(p, state_at_belt_speed, mode)[0]
        assert (-ax if mode is Mode.FORWARD else ax) >= -1e-6 * (abs(x) + abs(y) + 1.0)


@given(belts(), states(), st.sampled_from(SLIDING))
def test_friction_opposes_sliding_and_falls_from_its_static_value(
    p: Parameters, state: State, mode: Mode
) -> None:
    x, _, y, vy = state
    sign = 1.0 if mode is Mode.FORWARD else -1.0
    for speed in (0.0, 0.1, 1e3):
        sliding_state = (x, (p.v_belt or 0.0) - sign * speed, -abs(y), vy)
        force = friction_force(p, sliding_state, mode)
        assert force * sign >= 0.0
        assert p.mu <= friction_coefficient(p, speed) <= p.mu_static
    if p.speed_law is not None:
        assert friction_coefficient(p, 0.0) == pytest.approx(p.mu_static)
        assert friction_coefficient(p, p.speed_law) == pytest.approx(
            p.mu + (p.mu_static - p.mu) / math.e
        )


@given(st.floats(0.0, 800.0))
def test_the_exponential_by_arithmetic_alone_is_that_of_the_library(exponent: float) -> None:
    expected = math.exp(-exponent) if exponent < 700.0 else 0.0
    assert exponential(-exponent) == pytest.approx(expected, rel=4e-16 + 2e-16 * exponent)


def test_in_tension_the_slider_does_not_stick() -> None:
    p = Parameters(v_belt=1.0, mu=5.0)
    assert mode_of(p, (0.0, 1.0, -0.5, 0.0), separation=False) is Mode.STICK
    assert mode_of(p, (0.0, 1.0, 0.5, 0.0), separation=False) in SLIDING
    # The guard against slip forward: the margin of static friction over the holding force.
    assert guard_value(p, (0.0, 1.0, -0.5, 0.0), Guard.HELD_FORWARD) > 0.0


@pytest.mark.parametrize("kernel", ["interpreted", "compiled"])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("rises", [True, False])
def test_a_stick_with_zero_margin_and_rate_lasts_if_the_second_derivative_is_positive(
    kernel: KernelChoice, side: float, rises: bool
) -> None:
    # The margin is mu P - side f: for side 1 slip forward follows, for side -1 slip backward. The
    # holding force is f = c1 v + a x - h y at the belt speed v; the contact force is P = -k2 y.
    p = Parameters(m=2.0, k1=30.0, k2=20.0, k3=90.0, c1=0.5, c2=4.0, k_nl=0.0, v_belt=1.0, mu=0.5)
    h, y, speed = 0.5 * p.k3, -1.0, 1.0
    a = p.k1 + h
    # At y = -1 the margin is zero with this x, and its rate, -mu k2 vy - side (a v - h vy), with
    # this vy.
    x = (side * p.mu * p.k2 - p.c1 * speed + h * y) / a
    vy = a * speed / (h - side * p.mu * p.k2)
    # The second derivative is slope ay; the preload F that gives this ay decides its sign.
    slope = side * h - p.mu * p.k2
    ay = (0.5 if rises == (slope > 0.0) else -0.5) * p.c2 * vy / p.m
    p = p.with_values({"F": p.k2 + h * (x - y) - p.c2 * vy - p.m * ay})
    state = (x, speed, y, vy)
    slip_mode = Mode.FORWARD if side > 0.0 else Mode.BACKWARD
    expected = Mode.STICK if rises else slip_mode
    assert mode_of(p, state, separation=True) is expected
    run = simulate(p, t_end=1e-3, start=state, samples=[0.0, 5e-4, 1e-3], kernel=kernel)
    assert run.to_columns()["mode"].tolist() == [expected] * 3

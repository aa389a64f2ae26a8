"""Forces, equilibrium and energy of the model.

The modes `ALWAYS_SLIDING` are contact and separation, those of a belt that is always faster than
the slider.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.model.errors import ComputationError
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.slider_belt import (
    State,
    accelerations,
    contact_force,
    equilibrium,
    jacobian,
    mode_of,
    static_start,
)
from tests.support.energy import mechanical_energy, power
from tests.support.strategies import states, wide_parameters


@given(wide_parameters(), st.booleans())
@example(Parameters(k_nl=1e9, F=1e6), True)
@example(Parameters(k2=1e8), True)
@example(Parameters(k_nl=1e-300, F=1e-300), True)
def test_no_force_acts_at_the_equilibrium(p: Parameters, separation: bool) -> None:
    point = equilibrium(System(p, separation))
    ax, ay = accelerations(p, (point.x, 0.0, point.y, 0.0), point.mode)
    forces = max(abs(p.F), abs(point.P) * max(p.mu, 1.0), p.k3 * abs(point.y))
    assert abs(ax) * p.m <= 1e-12 * forces
    assert abs(ay) * p.m <= 1e-12 * forces


@given(wide_parameters())
def test_the_equilibrium_is_in_contact_and_the_contact_force_carries_it(p: Parameters) -> None:
    assume(p.F > 0.0)
    point = equilibrium(System(p))
    assert point.mode is Mode.CONTACT
    assert point.y < 0.0 < point.P <= p.F * (1.0 + 1e-12)


@given(wide_parameters(), st.floats(1e-3, 1e3))
def test_a_negative_preload_lifts_the_equilibrium_off_the_belt(p: Parameters, lift: float) -> None:
    assume(p.k3 > 0.0)
    point = equilibrium(System(p.with_values({"F": -lift})))
    assert point.mode is Mode.SEPARATED
    assert point.y > 0.0 == point.P


def test_nothing_holds_a_lifted_slider_without_the_coupling_spring() -> None:
    with pytest.raises(ComputationError, match="no equilibrium"):
        equilibrium(System(Parameters(F=-1.0, k3=0.0)))


def test_equilibrium_without_cubic_stiffness_is_that_of_the_linear_system() -> None:
    p = Parameters(k_nl=0.0, mu=0.0)
    coupling = 0.5 * p.k3
    stiffness = np.array([[p.k1 + coupling, -coupling], [-coupling, p.k2 + coupling]])
    expected = np.linalg.solve(stiffness, [0.0, -p.F])
    assert equilibrium(System(p)).x == pytest.approx(expected[0], rel=1e-14)
    assert equilibrium(System(p)).y == pytest.approx(expected[1], rel=1e-14)


@given(wide_parameters(), st.floats(-2.0, 2.0))
def test_contact_force_is_compressive_exactly_below_the_switch(p: Parameters, y: float) -> None:
    force = contact_force(p, y, Mode.CONTACT)
    assume(force != 0.0)
    assert (force > 0.0) == (y < 0.0)


@given(wide_parameters(), states())
def test_both_fields_agree_on_the_switch(p: Parameters, state: State) -> None:
    on_switch = (state[0], state[1], 0.0, state[3])
    assert accelerations(p, on_switch, Mode.CONTACT) == accelerations(p, on_switch, Mode.SEPARATED)


@given(wide_parameters(), st.floats(-1.5, 1.5), st.sampled_from(ALWAYS_SLIDING))
def test_jacobian_is_the_difference_quotient_of_the_accelerations(
    p: Parameters, y: float, mode: Mode
) -> None:
    matrix = np.array(jacobian(p, y, mode))
    at = np.array([0.3, -0.2, y, 0.4])
    step = 1e-5
    for column in range(4):
        shift = step * np.eye(4)[column]
        above, below = (tuple((at + sign * shift).tolist()) for sign in (1.0, -1.0))
        pair = [accelerations(p, state, mode) for state in (above, below)]
        quotient = (np.array(pair[0]) - np.array(pair[1])) / (2.0 * step)
        # The difference quotient of a cubic has an error of the order of the step squared.
        allowance = 1.01 * p.k_nl * step * step * (1.0 + p.mu) / p.m
        size = np.abs(matrix).max()
        assert matrix[[1, 3], column] == pytest.approx(quotient, abs=1e-6 * size + allowance)
    assert matrix[0].tolist() == [0.0, 1.0, 0.0, 0.0]
    assert matrix[2].tolist() == [0.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize("separation", [True, False])
def test_energy_changes_by_friction_input_less_damping_loss(separation: bool) -> None:
    p = Parameters()
    result = simulate(p, t_end=20.0, separation=separation, samples="dense")
    assert result.solution is not None
    # Gauss points between the switches, where the balance is smooth.
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.unique(np.concatenate((np.linspace(0.0, 20.0, 801), result.switch_times)))
    half = 0.5 * np.diff(edges)
    times = (edges[:-1] + half)[:, None] + half[:, None] * nodes
    motion = result.solution(times.ravel())
    # Power supplied by friction and power lost by damping, W.
    supplied, lost = np.transpose(
        [
            power(p, (x, vx, y, vy), Mode(mode))
            for x, vx, y, vy, mode in zip(
                motion.x, motion.vx, motion.y, motion.vy, motion.mode, strict=True
            )
        ]
    )
    net_work = float(((weights * half[:, None]).ravel() * (supplied - lost)).sum())
    end = (result.final.x, result.final.vx, result.final.y, result.final.vy)
    end_mode = mode_of(p, end, separation=separation)
    start_mode = mode_of(p, result.start, separation=separation)
    gained = mechanical_energy(p, end, end_mode) - mechanical_energy(p, result.start, start_mode)
    assert gained == pytest.approx(net_work, rel=1e-10)
    assert gained > 1.0


def test_energy_is_continuous_across_the_switch() -> None:
    p, state = Parameters(), (0.3, 1.0, 0.0, -2.0)
    assert mechanical_energy(p, state, Mode.CONTACT) == mechanical_energy(p, state, Mode.SEPARATED)


def test_static_start_is_the_equilibrium_without_friction_and_at_rest() -> None:
    x, vx, y, vy = static_start(System(Parameters(mu=0.7)))
    still = equilibrium(System(Parameters(mu=0.0)))
    assert (x, y) == (still.x, still.y)
    assert vx == vy == 0.0


def test_equilibrium_deepens_with_preload_and_rises_with_cubic_stiffness() -> None:
    deepening = [equilibrium(System(Parameters(F=force))).y for force in (0.0, 20.0, 50.0, 100.0)]
    assert deepening == sorted(deepening, reverse=True)
    rising = [equilibrium(System(Parameters(k_nl=k))).y for k in (0.0, 50.0, 100.0, 500.0)]
    assert rising == sorted(rising)
    assert all(equilibrium(System(Parameters(F=0.0, k_nl=k))).y == 0.0 for k in (0.0, 500.0))
    assert math.isclose(equilibrium(System(Parameters())).y, -0.629220913061061, rel_tol=1e-13)

"""Each rule of the model agrees in all modules that implement it.

The modes `ALWAYS_SLIDING` are contact and separation, those of a belt that is always faster than
the slider.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from fivtui import Parameters, simulate
from fivtui.equilibrium.arrays import StabilityPoints
from fivtui.model import System
from fivtui.model.errors import ComputationError
from fivtui.model.field import field, tangent_stiffness
from fivtui.model.modes import ALWAYS_SLIDING, Mode
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import (
    State,
    accelerations,
    contact_force,
    equilibrium,
    mode_of,
    static_deflection,
    time_scale,
)
from fivtui.sweeps.design import Design
from fivtui.sweeps.rows import _MemberBlock
from fivtui.sweeps.run import sweep
from fivtui.sweeps.study import Study
from fivtui.taylor.series import coefficient_function, right_hand_side
from fivtui.taylor.stepper import (
    LONGEST_STEP,
    MIN_SCALE_RATIO,
    TaylorStepper,
    order_for,
    rough_exp2,
    rough_log2,
)
from fivtui.transient.steppers.rk4 import RungeKutta4
from fivtui.transient.trajectory import build_trajectory
from tests.support.strategies import magnitudes, moderate_parameters, states, wide_parameters


@given(wide_parameters(), st.lists(st.floats(-1e3, 1e3), min_size=1), st.data())
def test_the_force_of_a_trajectory_is_that_of_every_state(
    p: Parameters, heights: list[float], data: st.DataObject
) -> None:
    modes = [data.draw(st.sampled_from(ALWAYS_SLIDING)) for _ in heights]
    y, zero = np.array(heights), np.zeros(len(heights))
    forces = build_trajectory(
        System(p), zero, (zero, zero, y, zero), np.array(modes, dtype=np.int8)
    ).P
    assert forces.tolist() == [
        contact_force(p, height, mode) for height, mode in zip(heights, modes, strict=True)
    ]


@pytest.mark.parametrize("separation", [True, False])
def test_the_least_and_greatest_force_of_a_sweep_are_those_of_the_runs(separation: bool) -> None:
    vary = {"k2": (40.0, 60.0), "k_nl": (0.0, 200.0)}
    result = sweep(vary=vary, separation=separation, t_end=10.0, outputs=["P_min", "P_max"])
    for k2, k_nl, _separation, least, greatest, _status, _reason in result.rows:
        run = simulate(Parameters(k2=k2, k_nl=k_nl), t_end=10.0, separation=separation)
        assert (least, greatest) == pytest.approx(run.contact_force, rel=1e-9)


@given(wide_parameters(), states(), st.sampled_from(ALWAYS_SLIDING))
def test_rk4_has_the_accelerations_of_the_model(p: Parameters, state: State, mode: Mode) -> None:
    rk4 = RungeKutta4([p], [state], step=1.0)
    computed = rk4._derivatives(np.array(state)[:, None], np.array([mode is Mode.CONTACT]))[:, 0]
    forces = np.abs([p.F, p.k1, p.k2, p.k3, p.k_nl, p.c1, p.c2]).sum() * (1.0 + p.mu) * 10.0
    expected = accelerations(p, state, mode)
    assert computed[[1, 3]].tolist() == pytest.approx(expected, abs=1e-13 * forces / p.m)


@given(wide_parameters(), st.floats(-1e4, 1e4), st.booleans())
def test_the_equilibrium_on_arrays_is_that_of_every_set(
    p: Parameters, preload: float, separation: bool
) -> None:
    p = p.with_values({"F": preload})
    with np.errstate(all="ignore"):
        points = StabilityPoints(p, {}, np.array([separation]))
    try:
        point = equilibrium(System(p, separation))
    except ComputationError:
        assert points.no_verdict.tolist() == [True]
        return
    assert points.no_verdict.tolist() == [separation and p.F == 0.0]
    stiffness = tangent_stiffness(p, point.y) if point.mode is Mode.CONTACT else 0.0
    assert points.kt[0] == pytest.approx(stiffness, rel=1e-12)


@given(moderate_parameters(), states(), st.sampled_from(["pushed", "at rest", "balanced"]))
def test_the_mode_at_the_switch_is_the_sign_of_the_first_derivative_of_y_that_is_not_zero(
    p: Parameters, state: State, kind: str
) -> None:
    x, vx, _, vy = state
    coupling = 0.5 * p.k3
    if kind != "pushed":
        vy = 0.0
    if kind == "balanced":
        assume(coupling > 0.0 and abs(coupling * vx) > 1e-3)
        x = p.F / coupling
    else:
        assume(vy != 0.0 or abs(coupling * x - p.F) > 1e-3)
    start = (x, vx, 0.0, vy)
    mode = mode_of(p, start, separation=True)
    for field_mode in ALWAYS_SLIDING:
        coefficients = coefficient_function(right_hand_side(p, field_mode), 4)
        _, y = coefficients(*start, *field(p, field_mode))
        if kind == "balanced":
            # ÿ is zero except for rounding.
            y = tuple(0.0 if abs(term) < 1e-9 else term for term in y)
        leading_term = next(term for term in y if term != 0.0)
        assert (leading_term > 0.0) == (mode is Mode.SEPARATED)
    assert TaylorStepper(System(p), start).advance().mode is mode


@given(moderate_parameters(), states(), st.sampled_from([1e-15, 1e-12, 1e-8]))
def test_a_step_ends_where_the_last_terms_reach_the_tolerance(
    p: Parameters, state: State, tol: float
) -> None:
    # The rule with exact powers and logarithms; the stepper approximates them to a few per cent.
    segment = TaylorStepper(System(p, separation=False), state, tol=tol).advance()
    order, time = order_for(tol), time_scale(p)
    coefficients = coefficient_function(right_hand_side(p, Mode.CONTACT), order)
    x, y = coefficients(*state, *field(p, Mode.CONTACT))
    # A coordinate z = Σ zₙ tⁿ has the velocity scale max(|ż|, |z|/time) at the start of the step.
    scales = [max(abs(z[1]), abs(z[0]) / time) for z in (x, y)]
    min_scale = MIN_SCALE_RATIO * max(*scales, static_deflection(p) / time)
    # A step ends at the least t at which a term n |zₙ| tⁿ⁻¹ of a velocity reaches tol · scale.
    allowed = [
        (tol * max(scale, min_scale) / (n * abs(z[n]))) ** (1.0 / (n - 1))
        for z, scale in zip((x, y), scales, strict=True)
        for n in (order + 1, order)
        if z[n] != 0.0
    ]
    expected = min([LONGEST_STEP * time, *allowed])
    assert segment.duration == pytest.approx(expected, rel=0.06)


@given(magnitudes(-300.0, 300.0), st.floats(-1000.0, 1000.0))
def test_approximate_logarithms_are_at_most_0_09_too_small_and_powers_within_3_1_percent(
    number: float, exponent: float
) -> None:
    assert 0.0 <= math.log2(number) - rough_log2(number) + 1e-12 <= 0.09
    assert rough_exp2(exponent) == pytest.approx(2.0**exponent, rel=0.031)


@given(st.lists(wide_parameters(), min_size=1, max_size=5))
def test_the_time_scales_of_a_sweep_are_those_of_its_members(sets: list[Parameters]) -> None:
    varied = {name: np.array([getattr(p, name) for p in sets]) for name in PARAMETERS}
    study = Study(Design({"F": (1.0, 2.0)}), Parameters())
    block = _MemberBlock(
        study,
        varied,
        separation=np.ones(len(sets), dtype=bool),
        results={},
        reasons=[""] * len(sets),
    )
    scales = block._time_scales(np.arange(len(sets)))
    assert scales.tolist() == pytest.approx([time_scale(p) for p in sets], rel=1e-15)

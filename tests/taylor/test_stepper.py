"""The Taylor integrator: errors, segments, known motions and orders."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.modes import Mode
from fivtui.model.slider_belt import State, static_start
from fivtui.taylor.polynomial import evaluate
from fivtui.taylor.stepper import (
    MAX_LAW_ORDER,
    MAX_ORDER,
    MIN_ORDER,
    TaylorStepper,
    order_for,
)
from tests.references import REFERENCES, Reference
from tests.support.strategies import moderate_parameters, states

every_reference = pytest.mark.parametrize("reference", REFERENCES.values(), ids=REFERENCES)


def relative_error(reference: Reference, tol: float) -> float:
    result = simulate(
        reference.parameters,
        t_end=reference.t_end,
        tol=tol,
        separation=reference.separation,
        start=reference.start,
    )
    final = (result.final.x, result.final.vx, result.final.y, result.final.vy)
    size = max(map(abs, reference.final))
    return max(abs(a - b) for a, b in zip(final, reference.final, strict=True)) / size


@every_reference
@pytest.mark.parametrize("tol", [1e-12, 1e-11, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3])
def test_the_error_of_the_end_state_is_at_most_twenty_times_the_tolerance(
    reference: Reference, tol: float
) -> None:
    assert relative_error(reference, tol) <= 20.0 * tol


@every_reference
def test_events_and_peak_equal_those_of_the_reference(reference: Reference) -> None:
    result = simulate(
        reference.parameters,
        t_end=reference.t_end,
        separation=reference.separation,
        start=reference.start,
    )
    assert result.events.separations == reference.separations
    assert result.switch_times.tolist() == pytest.approx(reference.switch_times, abs=1e-9)
    assert result.events.separated_time == pytest.approx(reference.separated_time, abs=1e-9)
    assert result.peak.y_abs == pytest.approx(reference.peak_y_abs, rel=1e-11)


@pytest.mark.parametrize("order", [8, 12, 16])
def test_the_error_falls_with_the_tolerance(order: int) -> None:
    p = Parameters()

    def state_at_end(tol: float) -> State:
        stepper = TaylorStepper(System(p), static_start(System(p)), tol=tol, order=order)
        while (segment := stepper.advance()).end < 20.0:
            pass
        return segment.state(20.0)

    exact_state = state_at_end(1e-16)
    loose, medium, tight = (
        max(map(abs, np.subtract(state_at_end(tol), exact_state))) for tol in (1e-6, 1e-9, 1e-12)
    )
    assert loose > 30.0 * medium
    assert medium > 30.0 * tight


@given(moderate_parameters(), states(), st.booleans())
def test_segments_are_continuous_and_stay_on_the_side_of_their_mode(
    p: Parameters, start: State, separation: bool
) -> None:
    stepper = TaylorStepper(System(p, separation=separation), start, tol=1e-12)
    state, end, switched, mode = start, 0.0, False, None
    for _ in range(60):
        try:
            segment = stepper.advance()
        except ComputationError:
            # Motion that never leaves a linear contact may grow without bound.
            assert not separation
            return
        assert segment.start == end
        assert segment.duration > 0.0
        assert segment.state(end) == pytest.approx(state, rel=1e-9, abs=1e-9)
        if mode is not None:
            assert (segment.mode is not mode) == switched
        coefficient_sum = sum(map(abs, segment.y))
        for fraction in np.linspace(0.02, 0.98, 25):
            y = evaluate(segment.y, float(fraction))
            wrong_side = y if segment.mode is Mode.CONTACT else -y
            assert not separation or wrong_side <= 1e-13 * coefficient_sum + 1e-25
        assert segment.final[2] == 0.0 or not segment.switches
        state, end, switched = segment.final, segment.end, segment.switches
        mode = segment.mode


def test_a_slider_at_rest_stays_at_rest() -> None:
    for p in (Parameters(mu=0.0), Parameters(F=0.0)):
        result = simulate(p, t_end=1e4)
        assert result.peak.y_max - result.peak.y_min < 1e-12
        assert result.events.separations == 0


def test_free_flight_without_coupling_is_ballistic() -> None:
    p = Parameters(k3=0.0, c1=0.0, c2=0.0, mu=0.0, F=5.0 * 9.81)
    result = simulate(p, t_end=1.0, start=(0.0, 0.0, 0.0, 9.81))
    assert result.peak.y_max == pytest.approx(0.5 * 9.81, rel=1e-13)
    assert result.final.y == pytest.approx(9.81 - 0.5 * 9.81, rel=1e-12)
    assert result.events.separated_time == 1.0


def test_the_linear_undamped_oscillator_follows_the_cosine() -> None:
    p = Parameters(k3=0.0, c1=0.0, c2=0.0, mu=0.0, F=0.0, k_nl=0.0)
    result = simulate(p, t_end=100.0, start=(1.0, 0.0, -1.0, 0.0), separation=False)
    assert result.final.x == pytest.approx(math.cos(math.sqrt(20.0) * 100.0), abs=1e-12)
    assert result.final.y == pytest.approx(-math.cos(math.sqrt(10.0) * 100.0), abs=1e-12)


@pytest.mark.parametrize("invalid", [0.0, -1.0, 1.0, math.nan])
def test_a_local_tolerance_out_of_range_is_refused(invalid: float) -> None:
    with pytest.raises(InputError, match="must be"):
        TaylorStepper(System(Parameters()), (0.0, 0.0, -1.0, 0.0), tol=invalid)


def test_a_start_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InputError, match="finite"):
        TaylorStepper(System(Parameters()), (0.0, math.nan, -1.0, 0.0))


def test_the_order_is_the_least_sufficient_multiple_of_four() -> None:
    # Orders 0.655 ln(1/tol), rounded up to multiples of four: 7.5, 11.9, 15.1, 15.96 and 19.6.
    tolerances = (1e-5, 1.2e-8, 1e-10, 2.6e-11, 1e-13)
    assert [order_for(tol) for tol in tolerances] == [8, 12, 16, 16, 20]
    assert order_for(0.5) == MIN_ORDER
    assert order_for(1e-300) == MAX_ORDER
    # Friction that falls with the sliding speed, by a law, has a greater limit.
    assert [order_for(tol, by_law=True) for tol in (1e-9, 1e-12, 1e-15)] == [16, 20, MAX_LAW_ORDER]
    for exponent in np.linspace(-20.0, -1.0, 400):
        order = order_for(10.0**exponent)
        expected_order = min(max(-0.655 * math.log(10.0) * exponent, MIN_ORDER), MAX_ORDER)
        assert order % 4 == 0
        assert expected_order - 1e-9 <= order < expected_order + 4.0

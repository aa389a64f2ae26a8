"""Limits of accuracy: if a numerical tolerance were 10,000 times larger, a test here would fail."""

import math

import numpy as np
import pytest

from fivtui import Parameters, simulate, stability
from fivtui.assessment.lyapunov import error_growth
from fivtui.model import System
from fivtui.model.errors import ComputationError
from fivtui.model.slider_belt import Mode, State
from fivtui.orbits.shooting import PeriodicOrbit, Section, shoot
from fivtui.taylor.polynomial import roots
from fivtui.transient.derivatives.variation import START_SEEDS, compute_variation
from fivtui.transient.request import Request

# F = 80 N: μ at the fold of separating cycles, and the period of the cycle there, s, by an
# independent continuation.
FOLD, FOLD_PERIOD = 0.277876613, 1.1945636
# F = 40 N: amplitude of the small cycle over the root of the distance from the Hopf point, m.
AMPLITUDE_RATIO = 3.53


def as_state(values: list[float]) -> State:
    x, vx, y, vy = values
    return (x, vx, y, vy)


@pytest.fixture(scope="module")
def cycle_at_fold() -> PeriodicOrbit:
    """The cycle near the fold, continued downwards from a transient."""
    p = Parameters(mu=0.3)
    run = simulate(
        p, t_end=200.0, start=(0.0, 0.0, 1.5, 3.0), samples="dense", kernel="interpreted"
    )
    assert run.solution is not None
    # Separations are every second switch, from the first on if the run starts in contact. The last
    # two are the ends of a cycle.
    first_separation = 1 if run.first_mode is Mode.SEPARATED else 0
    begin, end = run.switch_times[first_separation::2][-2:]
    motion = run.solution([begin])
    guess = as_state([float(motion.x[0]), float(motion.vx[0]), 0.0, float(motion.vy[0])])
    orbit = shoot(System(p), guess, float(end - begin), Section.LIFT_OFF)
    for distance in (1e-2, 2e-3, 3e-4, 4e-5, 2e-6, 4e-8):
        p = Parameters(mu=FOLD + distance)
        orbit = shoot(System(p), orbit.start, orbit.period, Section.LIFT_OFF)
    return orbit


def test_an_orbit_exists_just_above_the_fold_and_not_below(cycle_at_fold: PeriodicOrbit) -> None:
    assert cycle_at_fold.period == pytest.approx(FOLD_PERIOD, abs=5e-5)
    # Below the fold the return map misses by 1e-9 to 1e-8 of the orbit's size.
    for distance_below in (1e-9, 3e-9, 1e-8):
        with pytest.raises(ComputationError, match="no periodic orbit"):
            shoot(
                System(Parameters(mu=FOLD - distance_below)),
                cycle_at_fold.start,
                cycle_at_fold.period,
                Section.LIFT_OFF,
            )


def test_an_orbit_closes_and_agrees_with_a_run_over_one_period(
    cycle_at_fold: PeriodicOrbit,
) -> None:
    p = Parameters(mu=FOLD + 4e-8)
    run = simulate(
        p, t_end=cycle_at_fold.period, start=cycle_at_fold.start, method="scipy-dop853", tol=1e-13
    )
    final = (run.final.x, run.final.vx, run.final.y, run.final.vy)
    assert final == pytest.approx(cycle_at_fold.start, abs=1e-9)
    finest = simulate(
        p, t_end=cycle_at_fold.period, start=cycle_at_fold.start, tol=1e-13, kernel="interpreted"
    )
    assert cycle_at_fold.y_min == pytest.approx(finest.peak.y_min, rel=2e-13)
    assert cycle_at_fold.x_abs == pytest.approx(finest.peak.x_abs, rel=2e-13)
    assert cycle_at_fold.separated_time == pytest.approx(finest.events.separated_time, rel=1e-12)


@pytest.mark.parametrize("distance", [1e-4, 1e-6, 1e-9])
def test_a_small_cycle_is_distinguished_from_the_equilibrium(distance: float) -> None:
    # At a supercritical Hopf point the amplitude grows as the square root of the distance.
    critical = stability(Parameters(F=40.0)).critical_mu[0].mu
    p = Parameters(F=40.0, mu=critical + distance)
    verdict = stability(p)
    mode = max(verdict.modes, key=lambda mode: mode.growth_rate)
    # The deviation (x, y) from rest is a complex multiple of the mode's shape. At the lowest point
    # y is real and negative.
    shape_x, shape_y = mode.shape
    y = -AMPLITUDE_RATIO * math.sqrt(distance)
    x = shape_x / shape_y * y
    rest = verdict.equilibrium
    guess = (rest.x + x.real, (mode.eigenvalue * x).real, rest.y + y, 0.0)
    period = 2.0 * math.pi / mode.angular_frequency
    orbit = shoot(System(p), guess, period, Section.LOWEST_POINT)
    assert orbit.half_range / math.sqrt(distance) == pytest.approx(AMPLITUDE_RATIO, rel=2e-3)
    assert orbit.period == pytest.approx(period, rel=distance + 1e-9)


@pytest.mark.parametrize(
    ("p", "separation", "start"),
    [
        (Parameters(), True, "static"),
        (Parameters(mu=0.2), True, (0.1, 0.0, -0.5, 0.0)),
    ],
)
def test_errors_grow_as_the_derivative_of_the_flow(
    p: Parameters, separation: bool, start: State
) -> None:
    request = Request(System(p, separation), t_end=20.0, tol=1e-12, start=start)
    # `error_growth` measures the length of an error as that of (x, ẋ/ω, y, ẏ/ω), and begins with
    # four components of 1/2, whose length is 1.
    frequency = math.sqrt((p.k1 + p.k2 + p.k3) / p.m)
    units = np.array([1.0, frequency, 1.0, frequency])
    # The derivatives of the final state by the four components of the start.
    end = compute_variation(request, START_SEEDS).derivatives @ (0.5 * units)
    expected_growth = float(np.linalg.norm(end / units))
    assert error_growth(request).final == pytest.approx(expected_growth, rel=2e-5)


def test_the_derivative_of_the_flow_contracts_volume_to_rounding() -> None:
    # Liouville's formula: the trace of the Jacobian is −(c1 + c2)/m everywhere.
    p = Parameters()
    request = Request(System(p), t_end=3.0, tol=1e-13, start=(0.3, 1.0, -0.5, 2.0))
    derivative = compute_variation(request, START_SEEDS).derivatives
    contraction = math.exp(-(p.c1 + p.c2) / p.m * 3.0)
    assert np.linalg.det(derivative) == pytest.approx(contraction, rel=1e-13)


@pytest.mark.parametrize("damping", [1e-9, 1e-10])
def test_tiny_damping_is_stable_and_zero_damping_is_not(damping: float) -> None:
    p = Parameters(c1=damping, c2=damping, mu=0.0)
    verdict = stability(p)
    assert verdict.growth_rate == pytest.approx(-damping / (2.0 * p.m), rel=1e-4)
    assert verdict.stable
    assert not stability(Parameters(c1=0.0, c2=0.0, mu=0.0)).stable


def test_two_close_roots_near_the_start_are_both_found() -> None:
    # (t − δ)(t − 2 δ): a flight that lasts the fraction δ of a step, soon after its start.
    for fraction in (1e-9, 1e-11, 1e-13):
        assert list(roots([2.0 * fraction * fraction, -3.0 * fraction, 1.0])) == pytest.approx(
            [fraction, 2.0 * fraction], rel=1e-14
        )

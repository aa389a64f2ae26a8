"""Linear scenes are solved exactly, without steps."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from mpmath import expm, matrix, mp, mpf
from scipy.linalg import expm as scipy_expm

from fivtui import Parameters, accuracy, simulate
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.slider_belt import State
from fivtui.scene.run import simulate_to
from fivtui.transient.derivatives.digits import final_digits
from fivtui.transient.errors import rounding_error
from fivtui.transient.linear.exponential import LinearMotion
from fivtui.transient.linear.run import is_linear
from fivtui.transient.request import Request
from tests.support.strategies import moderate_parameters, states

SCENES: dict[str, tuple[dict[str, float], float]] = {
    "base": ({}, 100.0),
    "uncoupled": ({"k3": 0.0}, 30.0),
    "undamped": ({"c1": 0.0, "c2": 0.0}, 60.0),
    "undamped-resonance": ({"c1": 0.0, "c2": 0.0, "k3": 0.0, "k2": 100.0}, 40.0),
    "unloaded": ({"F": 0.0}, 30.0),
    "lifted": ({"F": -40.0}, 30.0),
    "unstable": ({"mu": 2.0}, 40.0),
    "strong-friction": ({"mu": 100.0}, 5.0),
    "hard-contact": ({"k2": 1e6}, 5.0),
    "light": ({"m": 1e-6}, 0.05),
}
START: State = (0.1, -1.0, 0.3, 2.0)


def linear_parameters(**changes: float) -> Parameters:
    return Parameters(**{"k_nl": 0.0} | changes)


def exact_final(p: Parameters, t: float, start: State) -> list[float]:
    # The exponential of the 5 × 5 matrix of the motion under load, in 50 digits.
    with mp.workdps(50):
        m, k1, k2, k3, c1, c2, F, _, mu = (mpf(value) for value in p.values())
        # The spring k3 at 45° acts along x and y with half of its stiffness.
        h = k3 / 2
        rates = matrix(
            [
                [0, 1, 0, 0, 0],
                [-(k1 + h) / m, -c1 / m, (h - mu * k2) / m, 0, 0],
                [0, 0, 0, 1, 0],
                [h / m, 0, -(k2 + h) / m, -c2 / m, -F / m],
                [0, 0, 0, 0, 0],
            ]
        )
        final = expm(rates * mpf(t)) * matrix([*start, 1])
        return [float(value) for value in final[:4]]


def motion_scales(run: Any) -> tuple[float, float]:
    # Sizes of displacements, m, and of speeds, m/s.
    p = run.parameters
    displacement = max(run.peak.x_abs, run.peak.y_abs)
    return displacement, displacement * ((p.k1 + p.k2 + p.k3) / p.m) ** 0.5


@pytest.mark.parametrize("name", SCENES)
def test_the_state_is_that_of_the_matrix_exponential_in_fifty_digits(name: str) -> None:
    changes, t_end = SCENES[name]
    run = simulate(linear_parameters(**changes), t_end=t_end, start=START, separation=False)
    assert run.stats.kernel == "exact"
    x, vx, y, vy = exact_final(run.parameters, t_end, START)
    displacement, speed = motion_scales(run)
    assert [run.final.x, run.final.y] == pytest.approx([x, y], abs=2e-13 * displacement)
    assert [run.final.vx, run.final.vy] == pytest.approx([vx, vy], abs=2e-13 * speed)


@pytest.mark.parametrize("name", [name for name in SCENES if name != "light"])
def test_all_results_of_a_run_agree_with_the_taylor_steps(name: str) -> None:
    changes, t_end = SCENES[name]
    times = np.linspace(0.0, t_end, 301)
    runs = [
        simulate(
            linear_parameters(**changes),
            t_end=t_end,
            start=START,
            separation=False,
            samples=times,
            kernel=kernel,
        )
        for kernel in ("exact", "interpreted")
    ]
    exact, stepped = runs
    displacement, speed = motion_scales(exact)
    for part, attribute, size in (
        ("peak", "y_max", displacement),
        ("peak", "y_min", displacement),
        ("peak", "x_abs", displacement),
        ("peak", "vx_max", speed),
        ("steady", "y_half_range", displacement),
        ("contact_force", "min", displacement * exact.parameters.k2),
        ("contact_force", "max", displacement * exact.parameters.k2),
    ):
        exact_value, stepped_value = (getattr(getattr(run, part), attribute) for run in runs)
        assert exact_value == pytest.approx(stepped_value, abs=2e-12 * size), attribute
    assert exact.events == stepped.events
    assert exact.trajectory is not None
    assert stepped.trajectory is not None
    for column, size in (("x", displacement), ("y", displacement), ("vx", speed), ("vy", speed)):
        exact_value, stepped_value = (
            getattr(run, column) for run in (exact.trajectory, stepped.trajectory)
        )
        assert exact_value == pytest.approx(stepped_value, abs=2e-12 * size), column
    assert np.all(exact.trajectory.mode == stepped.trajectory.mode)


@settings(max_examples=30)
@given(moderate_parameters(), states(), st.floats(0.01, 20.0))
def test_extremes_bound_a_dense_sampling_and_are_attained(
    p: Parameters, start: State, t_end: float
) -> None:
    p = p.with_values({"k_nl": 0.0})
    times = np.linspace(0.0, t_end, 4001)
    run = simulate(p, t_end=t_end, start=start, separation=False, samples=times)
    motion, size = run.trajectory, 1e-12 * sum(motion_scales(run)) + 1e-12
    assert motion is not None
    # Samples miss an extremum by at most the second derivative times the square of the spacing.
    spacing_squared = (t_end / 4000.0) ** 2
    sampling_error = np.abs(np.gradient(motion.vy, times)).max() * spacing_squared + size
    assert motion.y.max() - size <= run.peak.y_max <= motion.y.max() + sampling_error
    assert motion.y.min() + size >= run.peak.y_min >= motion.y.min() - sampling_error
    sampling_error = np.abs(np.gradient(motion.vx, times)).max() * spacing_squared + size
    assert (
        np.abs(motion.x).max() - size <= run.peak.x_abs <= np.abs(motion.x).max() + sampling_error
    )
    curvature = np.abs(np.gradient(np.gradient(motion.vx, times), times)).max()
    sampling_error = 2.0 * curvature * spacing_squared + size
    assert motion.vx.max() - size <= run.peak.vx_max <= motion.vx.max() + sampling_error
    second_half_y = motion.y[times >= 0.5 * t_end]
    assert 0.5 * np.ptp(second_half_y) <= run.steady.y_half_range + size


@pytest.mark.parametrize("changes", [{}, {"mu": 100.0}, {"c1": 0.0, "c2": 0.0}, {"m": 1e-6}])
def test_exponentials_agree_with_those_of_scipy(changes: dict[str, float]) -> None:
    # Levels number the time spans, each twice as long as the one before. Longer spans than that of
    # the level `base` follow from it by doubling.
    motion = LinearMotion(linear_parameters(**changes), 10.0)
    for level in (0, motion.base - 1, motion.base, motion.base + 3):
        expected = scipy_expm(motion.matrix * motion.spans[level])
        size = np.abs(expected).max()
        assert motion.exponentials[level] == pytest.approx(expected, rel=1e-12, abs=1e-13 * size)


def test_coalesced_modes_that_share_an_eigenvector_are_solved_exactly() -> None:
    # Undamped at the critical friction coefficient: two equal frequencies, one mode shape. Of the
    # base set h = k3/2 and a = k1 + k3/2.
    h, a, k2 = 30.0, 130.0, 50.0
    mu = ((a - k2 - h) ** 2 / 4.0 + h * h) / (h * k2)
    run = simulate(linear_parameters(c1=0.0, c2=0.0, mu=mu), t_end=200.0, separation=False)
    eigenvalues = np.linalg.eigvals(LinearMotion(run.parameters, 1.0).matrix)
    assert np.abs(eigenvalues.real).max() < 1e-6
    assert np.ptp(np.abs(eigenvalues.imag)) < 1e-6
    expected = exact_final(run.parameters, 200.0, run.start)
    final = [run.final.x, run.final.vx, run.final.y, run.final.vy]
    assert final == pytest.approx(expected, abs=1e-11 * max(motion_scales(run)))


def test_a_decayed_motion_over_a_long_horizon_needs_few_spans() -> None:
    # `max_steps` limits the number of time spans that are searched for extremes. Long spans after
    # the decay are not divided.
    run = simulate(linear_parameters(), t_end=1e7, separation=False, max_steps=5_000)
    assert run.stats.steps == 0
    short = simulate(linear_parameters(), t_end=100.0, separation=False)
    assert run.peak == short.peak
    assert run.steady.y_half_range < 1e-13


@pytest.mark.parametrize(
    ("damping", "t_end", "error"),
    [(0.32, 1e7, 1e-15), (1e-4, 1e7, 1e-15), (1e-4, 1e5, 1e-11), (0.0, 1e4, 1e-11)],
)
def test_a_long_motion_is_that_of_the_matrix_exponential_in_fifty_digits(
    damping: float, t_end: float, error: float
) -> None:
    run = simulate(
        linear_parameters(c1=damping, c2=damping), t_end=t_end, start=START, separation=False
    )
    x, _, y, _ = exact_final(run.parameters, t_end, START)
    displacement, _ = motion_scales(run)
    assert [run.final.x, run.final.y] == pytest.approx([x, y], abs=error * displacement)


def test_overflow_is_diagnosed_with_its_time() -> None:
    p = linear_parameters(k2=186.0, mu=2.0)
    growth_rate = np.linalg.eigvals(LinearMotion(p, 1.0).matrix).real.max()
    with pytest.raises(
        ComputationError, match=r"grows beyond the floating-point range at t = "
    ) as caught:
        simulate(p, t_end=1e4, separation=False)
    overflow_time = float(caught.value.why.partition("t = ")[2].split()[0])
    assert overflow_time == pytest.approx(np.log(1e300) / growth_rate, rel=0.02)
    bounded_run = simulate(p, t_end=0.99 * overflow_time, separation=False)
    assert np.isfinite(bounded_run.peak.y_abs)
    with pytest.raises(ComputationError):
        simulate(p, t_end=1.01 * overflow_time, separation=False)


def test_rest_stays_rest() -> None:
    run = simulate(linear_parameters(F=0.0), t_end=1e6, start=(0.0,) * 4, separation=False)
    assert (run.final.x, run.final.y, run.peak.y_abs, run.peak.vx_max) == (0.0, 0.0, 0.0, 0.0)


def test_the_dense_solution_is_the_sampled_one() -> None:
    times = np.linspace(0.0, 40.3, 777)
    sampled = simulate(linear_parameters(), t_end=40.3, separation=False, samples=times).trajectory
    solution = simulate(linear_parameters(), t_end=40.3, separation=False, samples="dense").solution
    assert sampled is not None
    assert solution is not None
    for column in ("x", "vx", "y", "vy", "P"):
        assert getattr(solution(times), column) == pytest.approx(
            getattr(sampled, column), rel=1e-12, abs=1e-12
        )


def test_the_exact_solution_is_for_linear_scenes() -> None:
    p = linear_parameters()
    assert is_linear(Request(System(p, separation=False)))
    assert not is_linear(Request(System(p)))
    assert not is_linear(Request(System(Parameters(), separation=False)))
    with pytest.raises(InputError, match="k_nl = 0, separation ignored"):
        simulate(p, separation=True, kernel="exact")


def test_runs_beyond_the_limits_of_the_exact_solution_are_refused() -> None:
    undamped = linear_parameters(c1=0.0, c2=0.0)
    with pytest.raises(ComputationError, match="search for extremes needs more than 1000 spans"):
        simulate(undamped, t_end=1e4, separation=False, max_steps=1000)
    with pytest.raises(ComputationError, match=r"dense solution needs \d+ polynomials"):
        simulate(
            linear_parameters(), t_end=1e6, separation=False, samples="dense", max_steps=10_000
        )


@pytest.mark.parametrize("name", [name for name in SCENES if name != "light"])
@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_errors_are_within_the_estimate_of_rounding(name: str, factor: float) -> None:
    changes, t_end = SCENES[name]
    # Growing motions overflow over a longer horizon.
    is_growing = name in ("unstable", "strong-friction")
    t_end *= 1.0 if is_growing else factor
    run = simulate(linear_parameters(**changes), t_end=t_end, start=START, separation=False)
    _, *final = run.final
    reference = exact_final(run.parameters, t_end, START)
    error = np.abs(np.subtract(final, reference)).max() / np.abs(reference).max()
    assert error <= 4.0 * rounding_error(run).final
    digits = final_digits(run)
    assert digits is not None
    for value, exact, count in zip(final, reference, digits, strict=True):
        assert count == 0 or abs(value - exact) <= 1.01 * 10.0**-count * abs(exact)


def test_a_requested_error_below_rounding_is_refused_and_estimates_exceed_the_error() -> None:
    p = linear_parameters(c1=0.0, c2=0.0, mu=0.2)
    request = Request(System(p, separation=False), t_end=2e4)
    with pytest.raises(ComputationError, match=r"error of final is about "):
        simulate_to({"final": 1e-13}, request)
    verified = simulate_to({"final": 1e-9}, request)
    exact = exact_final(p, 2e4, request.initial)
    _, *final = verified.transient.final
    error = np.abs(np.subtract(final, exact)).max() / np.abs(exact).max()
    assert 0.0 < error < verified.estimate.final < 1e-9
    report = accuracy(p, t_end=2e4, separation=False)
    assert abs(report.run.final.x - exact[0]) < report.estimates["x"].difference < 1e-9


def test_damping_keeps_rounding_errors_small_over_a_long_run() -> None:
    rounding = rounding_error(
        simulate(linear_parameters(c1=0.1, mu=0.2), t_end=1e6, separation=False)
    )
    assert rounding.final < 1e-14
    assert rounding.peak < 1e-12

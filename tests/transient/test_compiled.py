"""Single runs by the compiled kernel agree with those by interpreted code."""

import math
import sys

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st

from fivtui import Parameters, simulate
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.slider_belt import State
from fivtui.transient.request import KernelChoice
from fivtui.transient.result import Transient
from tests.support.strategies import moderate_parameters, states, wide_parameters

KERNELS: tuple[KernelChoice, ...] = ("interpreted", "compiled")


def simulate_with_both_kernels(p: Parameters, **options: object) -> tuple[Transient, Transient]:
    interpreted, compiled = (simulate(p, kernel=kernel, **options) for kernel in KERNELS)  # type: ignore[arg-type]
    return interpreted, compiled


def assert_runs_agree(
    interpreted: Transient, compiled: Transient, *, rtol: float, tighter: Transient | None = None
) -> None:
    # A run with a tighter tolerance shows how sensitive each value is to small errors.
    p, tighter_run = interpreted.parameters, tighter or interpreted
    length = max(interpreted.peak.x_abs, interpreted.peak.y_abs, abs(p.F) / (p.k1 + p.k2 + p.k3))
    speed = length * math.sqrt((p.k1 + p.k2 + p.k3) / p.m)
    scale = {"x": length, "y": length, "vx": speed, "vy": speed, "t": interpreted.t_end}
    # Rounding decides whether separations of a height of 1e-14 lengths occur. The duration of a
    # separation is proportional to the square root of its height, here 1e-7. The time off the belt
    # adds up the durations.
    separations = max(run.events.separations for run in (interpreted, compiled, tighter_run))
    grazing_time = 1e-7 * length / speed * separations if length > 0.0 else 0.0

    def assert_value_agrees(unit: str, part: str, name: str) -> None:
        value, expected, tighter_value = (
            getattr(getattr(run, part), name) for run in (compiled, interpreted, tighter_run)
        )
        allowed = rtol * scale[unit] + 10.0 * abs(tighter_value - expected)
        allowed += grazing_time if unit == "t" else 0.0
        # Subnormal numbers lack relative accuracy. The kernel multiplies derivatives by 2⁻⁶⁴, lest
        # they overflow: numbers below 2⁶⁴ times the least normal number become subnormal.
        allowed = max(allowed, sys.float_info.min * 2.0**64)
        assert value == pytest.approx(expected, rel=rtol, abs=allowed), name

    for name in ("x", "vx", "y", "vy"):
        assert_value_agrees(name, "final", name)
    for unit, name in (("y", "y_max"), ("y", "y_min"), ("x", "x_abs"), ("vx", "vx_max")):
        assert_value_agrees(unit, "peak", name)
    assert_value_agrees("y", "steady", "y_half_range")
    assert_value_agrees("t", "events", "separated_time")
    assert compiled.first_mode is interpreted.first_mode


# Rounding decides whether the slider separates by a height of the size of rounding errors.
@example(
    Parameters(m=1.0, k1=54.0, k2=20.0, k3=0.0, c1=1.875, c2=0.0, F=2.0, k_nl=239.0, mu=1.5),
    (1.75, 1.0, 0.0, 0.0),
    True,
    1e-12,
)
# The motion is so small that its squares are zero.
@example(
    Parameters(m=1.0, k1=20.0, k2=20.0, k3=0.0, c1=1.0, c2=0.0, F=1.3e-172, k_nl=0.0, mu=1.0),
    (0.0, 0.0, 0.0, 0.0),
    False,
    1e-9,
)
@given(moderate_parameters(), states(), st.booleans(), st.sampled_from([1e-12, 1e-9, 1e-5, 1e-2]))
def test_kernels_agree_to_rounding(
    p: Parameters, start: State, separation: bool, tol: float
) -> None:
    try:
        interpreted = simulate(
            p, t_end=10.0, start=start, separation=separation, tol=tol, kernel="interpreted"
        )
    except ComputationError as error:
        # The kernels may fail at different times and states: compare only the beginning of the
        # message, up to the time. 20 characters distinguish the reasons.
        beginning = error.why.split(" at ")[0][:20]
        with pytest.raises(ComputationError, match=beginning):
            simulate(p, t_end=10.0, start=start, separation=separation, tol=tol, kernel="compiled")
        return
    compiled = simulate(
        p, t_end=10.0, start=start, separation=separation, tol=tol, kernel="compiled"
    )
    tighter = simulate(
        p, t_end=10.0, start=start, separation=separation, tol=0.3 * tol, kernel="interpreted"
    )
    # Rounding errors grow along the run. At a loose tolerance they may decide whether the slider
    # grazes the belt: whether there is a short separation.
    assert_runs_agree(interpreted, compiled, rtol=1e-9 if tol < 1e-7 else 1e-3, tighter=tighter)


@given(wide_parameters(), st.booleans())
def test_kernels_agree_over_many_orders_of_magnitude(p: Parameters, separation: bool) -> None:
    t_end = 30.0 * math.sqrt(p.m / (p.k1 + p.k2 + p.k3))
    assume(t_end < 1e7)
    interpreted, compiled = simulate_with_both_kernels(p, t_end=t_end, separation=separation)
    tighter = simulate(p, t_end=t_end, separation=separation, tol=5e-13, kernel="interpreted")
    assert_runs_agree(interpreted, compiled, rtol=1e-9, tighter=tighter)


@given(moderate_parameters(), states(), st.floats(0.5, 20.0))
def test_extremes_are_those_of_the_dense_output(p: Parameters, start: State, t_end: float) -> None:
    run = simulate(p, t_end=t_end, start=start, samples="dense", kernel="compiled")
    assert run.solution is not None
    samples = run.solution(np.linspace(0.0, t_end, 4001))
    second_half = run.solution(np.linspace(0.5 * t_end, t_end, 4001))
    peak, spacing = run.peak, t_end / 4000.0
    # Samples miss an extremum by at most the acceleration times the square of the spacing. For ẋ
    # the rate of the acceleration counts: the error is allowed to be 10 times as large.
    stiffness = p.k1 + p.k2 + p.k3 + 3.0 * p.k_nl * peak.y_min**2
    # Above the peaks of x, y and ẋ in SI units, and never zero.
    size = peak.y_abs + peak.x_abs + peak.vx_max + 1.0
    # Shares of springs and dampers, 2, and of friction, μ.
    max_acceleration = stiffness / p.m * size * (2.0 + p.mu)
    sampling_error = spacing**2 * max_acceleration + 1e-9
    x_abs, y_half_range = np.abs(samples.x).max(), np.ptp(second_half.y) / 2.0
    for lower_bound, extreme, upper_bound in (
        (samples.y.max(), peak.y_max, samples.y.max() + sampling_error),
        (samples.y.min() - sampling_error, peak.y_min, samples.y.min()),
        (x_abs, peak.x_abs, x_abs + sampling_error),
        (samples.vx.max(), peak.vx_max, samples.vx.max() + 10.0 * sampling_error),
        (y_half_range, run.steady.y_half_range, y_half_range + sampling_error),
        (samples.P.max(), run.contact_force.max, math.inf),
    ):
        assert (
            lower_bound - 1e-9 * (1.0 + abs(lower_bound))
            <= extreme
            <= upper_bound + 1e-9 * (1.0 + abs(extreme))
        )


def test_an_extremum_just_after_a_start_of_tiny_acceleration_is_found() -> None:
    # As long as x is negligible, the coupling spring k3 makes ẍ proportional to y. y rises from
    # -2⁻⁵² m at 1 m/s: after 2⁻⁵² s ẍ changes its sign, and ẋ is least.
    p = Parameters(m=1.0, k1=20.0, k2=20.0, k3=1.0, c1=0.0, c2=0.0, F=5.0, k_nl=0.0, mu=0.0)
    interpreted, compiled = simulate_with_both_kernels(
        p, t_end=1.0, start=(0.0, 0.0, -(2.0**-52), 1.0)
    )
    assert compiled.peak.vx_max == pytest.approx(interpreted.peak.vx_max, rel=1e-12)


def test_samples_and_dense_output_are_those_of_the_interpreted_kernel() -> None:
    times = np.linspace(0.0, 40.0, 2001)
    interpreted, compiled = simulate_with_both_kernels(Parameters(), t_end=40.0, samples=times)
    dense = simulate(Parameters(), t_end=40.0, samples="dense", kernel="compiled").solution
    assert interpreted.trajectory is not None
    assert compiled.trajectory is not None
    assert dense is not None
    for name in ("t", "x", "vx", "y", "vy", "P"):
        expected = getattr(interpreted.trajectory, name)
        scale = np.abs(expected).max()
        for columns in (compiled.trajectory, dense(times)):
            assert np.abs(getattr(columns, name) - expected).max() <= 1e-11 * scale
    assert np.array_equal(interpreted.trajectory.mode, compiled.trajectory.mode)


def test_a_run_longer_than_every_buffer_keeps_all_its_switches() -> None:
    interpreted, compiled = simulate_with_both_kernels(
        Parameters(), t_end=700.0, tol=1e-6, samples="dense"
    )
    # The buffer of the compiled kernel holds 256 switches.
    assert interpreted.switch_times.size > 2 * 256
    assert compiled.switch_times.size == interpreted.switch_times.size
    assert np.all(np.diff(compiled.switch_times) > 0.0)
    assert interpreted.solution is not None
    assert compiled.solution is not None
    times = np.linspace(0.0, 700.0, 999)
    assert np.abs(interpreted.solution(times).y - compiled.solution(times).y).max() < 1e-3


def test_a_run_that_ends_on_a_switch_has_no_separated_time() -> None:
    first_switch = float(simulate(Parameters(), kernel="compiled").switch_times[0])
    for kernel in KERNELS:
        run = simulate(Parameters(), t_end=first_switch, kernel=kernel)
        assert run.final.y == pytest.approx(0.0, abs=1e-12)
        # The horizon equals the time of the switch up to the spacing of floats.
        assert run.events.separated_time == pytest.approx(0.0, abs=2e-15)


def test_switches_and_states_before_the_horizon_do_not_depend_on_it() -> None:
    long_run = simulate(Parameters(), t_end=50.0, kernel="compiled")
    delays = np.random.default_rng(0).uniform(1e-6, 0.03, long_run.switch_times.size)
    horizons = (long_run.switch_times + delays)[long_run.switch_times < 49.9].tolist()
    samples = simulate(Parameters(), t_end=50.0, samples=horizons, kernel="compiled").trajectory
    assert samples is not None
    assert len(horizons) > 60
    for index, t_end in enumerate(horizons):
        short_run = simulate(Parameters(), t_end=t_end, kernel="compiled")
        final = (short_run.final.x, short_run.final.vx, short_run.final.y, short_run.final.vy)
        assert final == tuple(getattr(samples, name)[index] for name in ("x", "vx", "y", "vy"))
        expected = long_run.switch_times[long_run.switch_times <= t_end]
        assert short_run.switch_times.tolist() == expected.tolist()


@pytest.mark.parametrize("kernel", KERNELS)
def test_each_kernel_explains_its_failures(kernel: KernelChoice) -> None:
    with pytest.raises(ComputationError, match=r"50 steps reach t = .*shorter horizon"):
        simulate(Parameters(), max_steps=50, kernel=kernel)
    growing = Parameters(k2=186.0, k_nl=0.0, mu=1.5)
    with pytest.raises(ComputationError, match=r"at t = \d+.* s .*use separation, a cubic"):
        simulate(growing, t_end=1e5, separation=False, kernel=kernel)
    stiff = Parameters(m=1e-12, k2=1e12, k_nl=0.0)
    with pytest.raises(ComputationError, match=r"faster than floating-point time|steps reach"):
        simulate(stiff, t_end=1e7, max_steps=10_000, start=(0.0, 0.0, 1.0, -1.0), kernel=kernel)


def test_a_contact_force_out_of_range_is_refused() -> None:
    p = Parameters(k_nl=0.0, k2=1e12, mu=0.0, F=0.0)
    for kernel in KERNELS:
        with pytest.raises(ComputationError, match="floating-point range"):
            simulate(p, t_end=1e-9, start=(0.0, 0.0, -1e300, 0.0), kernel=kernel)


def test_an_unknown_kernel_is_refused_with_a_suggestion() -> None:
    with pytest.raises(InputError, match="did you mean compiled"):
        simulate(Parameters(), kernel="compile")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no choice of kernels"):
        simulate(Parameters(), method="rk4", kernel="compiled", t_end=1.0)

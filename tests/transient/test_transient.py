"""Transients by the native methods, which need no FMU: values, samples, progress, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fivtui import Parameters, simulate
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.modes import Mode
from fivtui.model.slider_belt import State, contact_force
from fivtui.transient.methods import METHODS
from fivtui.transient.report import transient_rows
from fivtui.transient.request import KernelChoice, Start
from tests.support.strategies import moderate_parameters, states

METHODS_AND_KERNELS = [
    *((method, "auto") for method in METHODS),
    *(("taylor", kernel) for kernel in ("compiled", "interpreted", "exact")),
]
VARIABLE_STEP = [name for name, method in METHODS.items() if not method.fixed_step]


@pytest.mark.parametrize("separation", [True, False])
@pytest.mark.parametrize("t_end", [12.0, pytest.param(30.0, marks=pytest.mark.whole)])
@pytest.mark.parametrize(
    ("method", "setting", "error"),
    [
        ("scipy-dop853", {"tol": 1e-9}, 1e-5),
        ("scipy-radau", {"tol": 1e-7}, 1e-3),
        ("scipy-lsoda", {"tol": 1e-9}, 1e-4),
        ("rk4", {"step": 4e-3}, 1e-3),
    ],
)
def test_every_method_gives_the_same_transient(
    method: str, setting: dict[str, Any], error: float, t_end: float, separation: bool
) -> None:
    p = Parameters()
    reference = simulate(p, t_end=t_end, separation=separation)
    run = simulate(p, t_end=t_end, separation=separation, method=method, **setting)
    assert run.method == method
    assert run.events.separations == reference.events.separations
    for value, expected, tolerance in (
        (run.events.separated_time, reference.events.separated_time, error),
        (run.final.y, reference.final.y, error),
        (run.peak.y_abs, reference.peak.y_abs, error),
        (run.peak.vx_max, reference.peak.vx_max, 10.0 * error),
        (run.steady.y_half_range, reference.steady.y_half_range, error),
    ):
        assert value == pytest.approx(expected, abs=tolerance)


@settings(max_examples=40)
@given(moderate_parameters(), states(), st.floats(0.5, 8.0))
def test_extremes_bound_a_dense_sampling_and_are_attained(
    p: Parameters, start: State, t_end: float
) -> None:
    times = np.linspace(0.0, t_end, 4001)
    result = simulate(p, t_end=t_end, start=start, samples=times)
    motion = result.trajectory
    assert motion is not None
    size = 1e-9 + 1e-12 * (np.abs(motion.y).max() + np.abs(motion.vx).max())
    # Samples miss an extremum by at most the curvature times dt²/8.
    spacing = t_end / 4000.0
    sampling_error = np.abs(np.gradient(motion.vy, times)).max() * spacing**2 + size
    assert motion.y.max() - size <= result.peak.y_max <= motion.y.max() + sampling_error
    assert motion.y.min() + size >= result.peak.y_min >= motion.y.min() - sampling_error
    sampling_error = np.abs(np.gradient(motion.vx, times)).max() * spacing**2 + size
    assert (
        np.abs(motion.x).max() - size
        <= result.peak.x_abs
        <= np.abs(motion.x).max() + sampling_error
    )
    assert motion.vx.max() - size <= result.peak.vx_max
    second_half_y = motion.y[times >= 0.5 * t_end]
    assert 0.5 * np.ptp(second_half_y) <= result.steady.y_half_range + size
    assert motion.P.max() <= result.contact_force.max * (1.0 + 1e-12) + size
    assert result.contact_force.min >= 0.0


@pytest.mark.parametrize("method", METHODS)
def test_a_horizon_inside_a_step_ends_the_run_there(method: str) -> None:
    exact = simulate(Parameters(), t_end=3.01)
    run = simulate(Parameters(), t_end=3.01, tol=1e-8, method=method)
    assert run.final.t == 3.01
    assert run.final.y == pytest.approx(exact.final.y, abs=1e-4)
    assert run.steady.y_half_range == pytest.approx(exact.steady.y_half_range, abs=1e-4)


def test_samples_are_the_dense_solution_at_those_times() -> None:
    times = np.linspace(0.0, 40.0, 1234)
    sampled = simulate(Parameters(), t_end=40.0, samples=times).trajectory
    dense = simulate(Parameters(), t_end=40.0, samples="dense").solution
    assert sampled is not None
    assert dense is not None
    for name in ("t", "x", "vx", "y", "vy", "P", "mode"):
        column = getattr(sampled, name)
        assert column == pytest.approx(getattr(dense(times), name), rel=1e-11, abs=1e-11)
    assert sampled.t.size == times.size


def test_trajectories_are_stored_only_on_request() -> None:
    result = simulate(Parameters(), t_end=5.0)
    assert result.trajectory is None
    assert result.solution is None


def test_the_result_does_not_depend_on_stored_samples() -> None:
    plain = simulate(Parameters(), t_end=30.0)
    sampled = simulate(Parameters(), t_end=30.0, samples=[0.0, 1.0, 30.0])
    assert plain.final == sampled.final
    assert plain.peak == sampled.peak
    assert plain.events == sampled.events


def test_the_last_sample_is_the_final_state() -> None:
    result = simulate(Parameters(), t_end=12.5, samples=[12.5])
    assert result.trajectory is not None
    assert result.trajectory.y[0] == pytest.approx(result.final.y, abs=1e-13)
    assert result.trajectory.vx[0] == pytest.approx(result.final.vx, abs=1e-13)


def test_separated_intervals_are_where_the_slider_is_off_the_belt() -> None:
    result = simulate(Parameters(), t_end=40.0, samples="dense")
    assert result.solution is not None
    lengths = []
    for start, end in result.separated_intervals:
        inside = result.solution(np.linspace(start, end, 52)[1:-1])
        assert np.all(inside.y > 0.0)
        assert np.all(inside.mode == Mode.SEPARATED)
        assert np.all(inside.P == 0.0)
        lengths.append(end - start)
    assert math.fsum(lengths) == pytest.approx(result.events.separated_time, abs=1e-10)
    assert result.events.first == result.switch_times[0]
    assert result.events.last == result.switch_times[-1]


def test_a_start_off_the_belt_has_one_more_landing_than_separations() -> None:
    result = simulate(Parameters(mu=0.0), t_end=2.0, start=(0.0, 0.0, 1.0, 0.0))
    assert result.first_mode is Mode.SEPARATED
    assert result.events.reattachments == result.events.separations + 1
    assert result.separated_intervals[0][0] == 0.0
    assert result.switch_times[0] == result.separated_intervals[0][1]


def test_contact_force_extremes_are_those_of_the_contact_law() -> None:
    considered = simulate(Parameters())
    ignored = simulate(Parameters(), separation=False)
    assert considered.contact_force.min == 0.0
    deepest = contact_force(considered.parameters, considered.peak.y_min, Mode.CONTACT)
    assert considered.contact_force.max == deepest
    highest = contact_force(ignored.parameters, ignored.peak.y_max, Mode.CONTACT)
    assert ignored.contact_force.min == highest < 0.0


def test_a_stable_scene_settles_without_separation() -> None:
    result = simulate(Parameters(mu=0.2), t_end=400.0)
    assert result.events.separations == 0
    assert result.events.first is None
    assert result.events.last is None
    assert result.steady.y_half_range < 1e-2 * (result.peak.y_max - result.peak.y_min)


@pytest.mark.parametrize(("method", "kernel"), METHODS_AND_KERNELS)
def test_progress_rises_to_one_and_can_cancel(method: str, kernel: KernelChoice) -> None:
    fractions: list[float] = []

    def record_fraction(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    # The exact solution is for linear scenes, without separation.
    p, is_exact = Parameters(c1=0.0, c2=0.0, k_nl=0.0), kernel == "exact"
    t_end = 500.0 if is_exact else 2.0
    options: dict[str, Any] = {"method": method, "kernel": kernel, "separation": not is_exact}
    simulate(p, t_end=t_end, tol=1e-6, progress=record_fraction, **options)
    assert fractions == sorted(fractions)
    # The exact solution reports progress only in its search for extremes, not at the start.
    if not is_exact:
        assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    with pytest.raises(Cancelled):
        simulate(p, t_end=500.0, progress=lambda fraction: fraction <= 0.01, **options)


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({"t_end": 0.0}, "t_end"),
        ({"t_end": math.nan}, "t_end"),
        ({"t_end": 1e9}, "t_end"),
        ({"tol": 0.0}, "tol"),
        ({"tol": 1e-20}, "tol"),
        ({"tol": math.inf}, "tol"),
        ({"method": "tailor"}, "did you mean taylor"),
        ({"method": ""}, "known: taylor"),
        ({"start": "rest"}, "static"),
        ({"start": (0.0, 1.0)}, "four"),
        ({"start": 3.0}, "four"),
        ({"start": ("a", 0.0, 0.0, 0.0)}, "four"),
        ({"start": (0.0, math.inf, 0.0, 0.0)}, "finite"),
        # The default method, taylor, takes tol in place of a step.
        ({"step": 0.1}, "tol"),
        ({"method": "rk4", "step": -1.0}, "step"),
        ({"method": "rk4", "step": 1e6}, "step"),
        ({"samples": [1.0, 0.5]}, "ascending"),
        ({"samples": [0.0, 101.0]}, "100"),
        ({"samples": []}, "samples"),
        ({"samples": "all"}, "dense"),
    ],
)
def test_a_wrong_request_is_refused_in_one_line(request_: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        simulate(Parameters(), **request_)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("method", "start"),
    [
        *((method, "static") for method in VARIABLE_STEP if method != "scipy-radau"),
        # So far from rest the motion overflows soon; from rest it takes a hundred thousand steps.
        ("scipy-radau", (0.0, 0.0, -1e140, 0.0)),
        pytest.param("scipy-radau", "static", marks=pytest.mark.whole),
    ],
)
def test_unbounded_growth_never_ends_in_nan(method: str, start: Start) -> None:
    p = Parameters(k2=186.0, k_nl=0.0, mu=2.0)
    with pytest.raises(ComputationError):
        simulate(p, t_end=1e4, tol=1e-6, separation=False, method=method, start=start)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("max_steps", [0, -1, 0.5, True, math.nan, "7", None])
def test_a_number_of_steps_below_one_is_refused_by_one_line(method: str, max_steps: Any) -> None:
    with pytest.raises(InputError, match=f"^max_steps = {max_steps}: must be a whole number, at"):
        simulate(t_end=1.0, method=method, max_steps=max_steps)


@pytest.mark.parametrize("method", ["taylor", "scipy-lsoda"])
def test_a_report_says_of_a_peak_that_it_is_not_sampled_not_that_it_is_exact(method: Any) -> None:
    run = simulate(t_end=5.0, tol=1e-2, method=method)
    notes = {row.label: row.note for row in transient_rows(run)}
    assert notes["peak |y|"] == "not sampled"

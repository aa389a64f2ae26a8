"""Branches of limit cycles: against closed forms, transients, and other integrators."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from fivtui import ComputationError, InputError, Parameters, branch, simulate, stability
from fivtui.equilibrium import critical_mu
from fivtui.model import System, accelerations, mode_of
from fivtui.orbits import cycles_at
from fivtui.orbits.boundaries.result import BoundaryPoint
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.hopf import hopf_point, hopf_values
from fivtui.orbits.curves.result import CycleBranch, CyclePoint

# By F, N: μ of the Hopf point, of the cycle that touches y = 0 and of the fold, and the period at
# the fold, s. A separate program, which is not in this repository, computed them.
KNOWN_EVENTS = {
    80.0: (0.439387619, 0.370729887, 0.277876613, 1.1945636),
    120.0: (0.762298519, 0.598203381, 0.277935093, 1.1945678),
}
STABILITY_LOSSES = (EventKind.PERIOD_DOUBLING, EventKind.TORUS)


def values_of(curve: CycleBranch, kind: EventKind) -> list[float]:
    return [event.value for event in curve.events if event.kind is kind]


def find_point(curve: CycleBranch, value: float) -> CyclePoint:
    return next(point for point in curve.points if point.value == value)


def parameters_at(curve: CycleBranch, value: float) -> Parameters:
    return curve.parameters.with_values({curve.name: value})


def random_sets(count: int, seed: int) -> Iterator[Parameters]:
    random = np.random.default_rng(seed)
    for _ in range(count):
        low = [1.0, 50.0, 20.0, 20.0, 0.05, 0.05, 5.0, 1.0]
        high = [10.0, 300.0, 200.0, 150.0, 2.0, 2.0, 200.0, 500.0]
        names = ("m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl")
        yield Parameters(**dict(zip(names, random.uniform(low, high).tolist(), strict=True)))


@pytest.fixture(scope="module", params=KNOWN_EVENTS)
def base_branch(request: pytest.FixtureRequest) -> CycleBranch:
    return branch(Parameters(F=request.param), "mu", low=0.0, high=1.2)


def test_the_branch_passes_lift_off_and_turns_at_the_known_fold(base_branch: CycleBranch) -> None:
    kinds = [event.kind for event in base_branch.events]
    assert kinds == [EventKind.HOPF, EventKind.TOUCH, EventKind.FOLD]
    *values, period = KNOWN_EVENTS[base_branch.parameters.F]
    assert [event.value for event in base_branch.events] == pytest.approx(values, abs=1e-8)
    assert base_branch.events[-1].period == pytest.approx(period, abs=5e-8)
    assert base_branch.events[0].direction == "subcritical"
    assert base_branch.events[1].y_max == pytest.approx(0.0, abs=1e-11)
    assert base_branch.ends == (End.EQUILIBRIUM, End.BOUND)
    assert base_branch.points[-1].value == 1.2


def test_a_multiplier_is_one_at_the_fold_where_stability_changes(base_branch: CycleBranch) -> None:
    (fold,) = values_of(base_branch, EventKind.FOLD)
    index = base_branch.points.index(find_point(base_branch, fold))
    assert min(abs(value - 1.0) for value in base_branch.points[index].multipliers) < 1e-6
    assert not any(point.stable for point in base_branch.points[:index])
    assert all(point.stable for point in base_branch.points[index + 1 :])


@pytest.mark.parametrize("change", [5e-5, 5e-6])
def test_the_fold_is_where_transients_stop_dying_out(
    base_branch: CycleBranch, change: float
) -> None:
    (fold,) = values_of(base_branch, EventKind.FOLD)
    point = find_point(base_branch, fold)
    sustained, dying = (
        simulate(parameters_at(base_branch, fold + offset), t_end=20_000.0, start=point.start)
        for offset in (change, -change)
    )
    assert sustained.steady.y_half_range == pytest.approx(point.half_range, rel=0.2)
    assert dying.steady.y_half_range < 1e-6


def assert_cycle_closes(curve: CycleBranch, point: CyclePoint) -> None:
    assert_orbit_closes(parameters_at(curve, point.value), point, separation=curve.separation)


def assert_orbit_closes(
    p: Parameters, point: CyclePoint | BoundaryPoint, *, separation: bool
) -> None:
    run = simulate(
        p,
        t_end=point.period,
        start=point.start,
        method="scipy-dop853",
        tol=1e-12,
        separation=separation,
    )
    final = (run.final.x, run.final.vx, run.final.y, run.final.vy)
    size = max(map(abs, point.start))
    assert final == pytest.approx(point.start, abs=1e-9 * size)
    assert run.peak.y_max == pytest.approx(point.y_max, abs=1e-8 * size)


def test_cycles_close_under_another_integrator(base_branch: CycleBranch) -> None:
    for point in base_branch.points[5::20]:
        assert_cycle_closes(base_branch, point)


def independent_multipliers(curve: CycleBranch, point: CyclePoint) -> np.ndarray:
    """Multipliers across a cycle from differences of runs by SciPy."""
    p = parameters_at(curve, point.value)
    frequency = 2.0 * math.pi / point.period
    scales = np.array([1.0, frequency, 1.0, frequency]) * point.half_range
    step = 1e-5

    def state_after_period(start: np.ndarray) -> np.ndarray:
        run = simulate(
            p,
            start=start.tolist(),
            separation=curve.separation,
            method="scipy-dop853",
            tol=1e-12,
            t_end=point.period,
        )
        return np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])

    start = np.array(point.start)
    # In units of `scales`: a row has the derivatives of the state after a period by one component
    # of the start.
    derivatives = [
        (state_after_period(start + change) - state_after_period(start - change))
        / (2.0 * step * scales)
        for change in step * np.diag(scales)
    ]
    ax, ay = accelerations(p, point.start, mode_of(p, point.start, separation=curve.separation))
    _, vx, _, vy = point.start
    rate = np.array([vx, ax, vy, ay]) / scales
    # Q of this 4 × 5 matrix is 4 × 4. Its first column is along the motion, and so the others are
    # normal to it.
    orthogonal, _ = np.linalg.qr(np.column_stack([rate, np.eye(4)]))
    normals = orthogonal[:, 1:4]
    return np.linalg.eigvals(normals.T @ np.array(derivatives).T @ normals)


def count_confirmed_folds(p: Parameters) -> int:
    curve = branch(p, "mu", low=0.0, high=10.0)
    folds = values_of(curve, EventKind.FOLD)
    for fold in folds:
        point = find_point(curve, fold)
        assert_cycle_closes(curve, point)
        if abs(point.y_max) > 1e-3 * abs(point.y_min):
            # Near a touch differences do not approximate derivatives.
            assert np.abs(independent_multipliers(curve, point) - 1.0).min() < 1e-5
    return len(folds)


def test_folds_of_random_sets_are_folds_of_another_integrator() -> None:
    assert sum(map(count_confirmed_folds, random_sets(2, 11))) > 0


@pytest.mark.whole
def test_folds_of_ten_random_sets_are_folds_of_another_integrator() -> None:
    assert sum(count_confirmed_folds(p) > 0 for p in random_sets(25, 11)) >= 10


def test_the_product_of_the_multipliers_is_the_contraction_of_volume(
    base_branch: CycleBranch,
) -> None:
    p = base_branch.parameters
    for point in base_branch.points:
        contraction = math.exp(-(p.c1 + p.c2) / p.m * point.period)
        assert np.prod(point.multipliers) == pytest.approx(contraction, rel=1e-7)


def test_from_a_cycle_the_same_branch_is_found_both_ways(base_branch: CycleBranch) -> None:
    p = base_branch.parameters.with_values({"mu": 0.8})
    curve = branch(p, "mu", low=0.0, high=1.2, origin="cycle")
    assert curve.ends == base_branch.ends
    assert [event.kind for event in curve.events] == [event.kind for event in base_branch.events]
    for curve_event, expected_event in zip(curve.events, base_branch.events, strict=True):
        assert curve_event.value == pytest.approx(expected_event.value, abs=1e-10)
    assert find_point(curve, 0.8).stable


def test_a_branch_has_cycles_at_the_ends_of_its_range_and_at_each_of_its_points() -> None:
    curve = branch(None, "mu", low=0.3, high=0.9, origin="cycle")
    low_end, high_end = curve.points[0], curve.points[-1]
    assert (low_end.value, high_end.value) == (0.3, 0.9)
    for point in (low_end, curve.points[1], high_end):
        (cycle,) = cycles_at(curve, point.value)
        assert cycle.value == point.value
        assert cycle.period == pytest.approx(point.period, rel=1e-9)
        assert cycle.y_max == pytest.approx(point.y_max, rel=1e-9)
    middle = 0.5 * (low_end.value + curve.points[1].value)
    (cycle,) = cycles_at(curve, middle)
    assert cycle.value == middle
    assert cycles_at(curve, 0.299) == cycles_at(curve, 0.901) == ()


def test_at_40_newtons_the_hopf_point_is_supercritical_and_cycles_begin_above_it() -> None:
    curve = branch(Parameters(F=40.0), "mu", high=1.0)
    assert curve.events[0].direction == "supercritical"
    assert curve.points[0].stable
    assert curve.points[0].value > curve.events[0].value
    assert not values_of(curve, EventKind.FOLD)


def test_at_30_newtons_two_folds_are_distinguished() -> None:
    curve = branch(Parameters(F=30.0), "mu", low=0.3, high=0.6)
    assert [event.kind.value for event in curve.events] == ["hopf", "fold", "touch", "fold"]
    upper, lower = values_of(curve, EventKind.FOLD)
    assert lower < curve.events[0].value < upper
    assert upper - lower < 3e-3
    # Between the folds there are three cycles.
    middle = 0.5 * (upper + curve.events[0].value)
    signs = np.sign([point.value - middle for point in curve.points])
    assert np.count_nonzero(np.diff(signs)) == 3


def test_without_cubic_stiffness_all_cycles_in_contact_are_at_the_linear_boundary() -> None:
    curve = branch(Parameters(k_nl=0.0), "mu", low=0.5, high=2.0)
    # The μ at which the equilibrium of the system with k_nl = 0 loses its stability.
    critical = stability(Parameters(k_nl=0.0)).linear_critical_mu
    hopf, touch = curve.events
    assert hopf.direction == "degenerate"
    assert touch.kind is EventKind.TOUCH
    assert touch.value == pytest.approx(critical, abs=1e-9)


@pytest.mark.parametrize("k_nl", [1e-6, 1e-3])
def test_with_little_cubic_stiffness_touch_and_fold_are_distinguished(k_nl: float) -> None:
    for name, mu in (("mu", 0.7), ("c1", 0.95), ("k1", 1.0)):
        curve = branch(Parameters(k_nl=k_nl, mu=mu), name)
        assert [event.kind.value for event in curve.events] == ["hopf", "touch", "fold"]


def test_where_separation_is_ignored_no_cycle_touches() -> None:
    curve = branch(None, "mu", high=2.0, separation=False)
    assert {event.kind for event in curve.events} == {EventKind.HOPF, EventKind.FOLD}
    (fold,) = values_of(curve, EventKind.FOLD)
    assert_cycle_closes(curve, find_point(curve, fold))


def test_a_branch_between_two_hopf_points_ends_at_both() -> None:
    curve = branch(None, "k1")
    assert curve.ends == (End.EQUILIBRIUM, End.EQUILIBRIUM)
    first, end = values_of(curve, EventKind.HOPF)
    for value in (first, end):
        assert critical_mu(System(Parameters(k1=value)))[0].mu == pytest.approx(0.7, abs=1e-12)
    assert curve.points[-1].half_range < 0.01
    assert curve.points[-1].value == pytest.approx(end, abs=1e-3 * end)


@pytest.mark.parametrize("name", ["m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl"])
def test_hopf_points_along_any_parameter_are_those_of_the_closed_form(name: str) -> None:
    for random_set in random_sets(6, 7):
        value = 1.3 * getattr(random_set, name)
        (critical,) = critical_mu(System(random_set.with_values({name: value})))
        p = random_set.with_values({"mu": critical.mu})
        hopf_points = hopf_values(System(p), name, value / 10.0, value * 10.0)
        assert min(abs(hopf_value - value) for hopf_value in hopf_points) < 1e-9 * value
        for hopf_value in hopf_points:
            critical_points = critical_mu(System(p.with_values({name: hopf_value})))
            assert critical_points[0].mu == pytest.approx(critical.mu, rel=1e-12)


def test_cycles_next_to_a_hopf_point_have_the_size_of_the_normal_form() -> None:
    # The normal form: 0 = σ' (μ − μ_c) + l a²/4, with the amplitude a of y.
    for p in random_sets(6, 3):
        (mu_c,) = hopf_values(System(p), "mu", 0.0, 100.0)
        hopf = hopf_point(System(p.with_values({"mu": mu_c})), "mu")
        rates = [stability(p.with_values({"mu": mu_c + d})).growth_rate for d in (1e-6, -1e-6)]
        first = branch(p, "mu", low=0.999 * mu_c, high=1.001 * mu_c).points[0]
        slope = (rates[0] - rates[1]) / 2e-6
        expected = -hopf.lyapunov * first.half_range**2 / (4.0 * slope)
        assert first.value - mu_c == pytest.approx(expected, rel=1e-3)
        assert first.period == pytest.approx(2.0 * np.pi / hopf.omega, rel=1e-4)


def assert_stability_changes_at_events(p: Parameters) -> set[EventKind]:
    # The branch is followed to its ends, and its stability changes only at events.
    curve = branch(p, "mu", low=0.0, high=10.0)
    assert not {End.LOST, End.TOO_LONG} & set(curve.ends)
    assert curve.events[0].value == critical_mu(System(p))[0].mu
    is_supercritical = curve.events[0].direction == "supercritical"
    assert curve.points[0].stable == is_supercritical
    assert (curve.points[0].value > curve.events[0].value) == is_supercritical
    events = {event.value: event.kind for event in curve.events}
    for index, point in enumerate(curve.points[1:-1], start=1):
        before, after = curve.points[index - 1], curve.points[index + 1]
        kind = events.get(point.value)
        if kind is None:
            assert point.stable in (before.stable, after.stable)
            continue
        assert_cycle_closes(curve, point)
        sizes = np.abs(point.multipliers)
        if kind is EventKind.FOLD:
            assert (point.value - before.value) * (after.value - point.value) < 0.0
            assert min(abs(value - 1.0) for value in point.multipliers) < 1e-6
        if kind is EventKind.PERIOD_DOUBLING:
            assert min(abs(value + 1.0) for value in point.multipliers) < 1e-6
        if kind is EventKind.TORUS:
            is_complex = np.abs(np.imag(point.multipliers)) > 1e-6
            assert np.abs(sizes[is_complex] - 1.0).max() < 1e-6
    changes = sum(
        point_before.stable != point_after.stable
        for point_before, point_after in zip(curve.points, curve.points[1:], strict=False)
        if not {point_before.value, point_after.value} & events.keys()
    )
    assert changes == 0
    return set(events.values())


def test_stability_of_random_branches_changes_only_at_events() -> None:
    event_kinds = set[EventKind]().union(
        *map(assert_stability_changes_at_events, random_sets(8, 5))
    )
    assert {EventKind.FOLD, EventKind.PERIOD_DOUBLING} <= event_kinds


@pytest.mark.whole
def test_stability_of_many_random_branches_changes_only_at_events() -> None:
    event_kinds = set[EventKind]().union(
        *map(assert_stability_changes_at_events, random_sets(60, 5))
    )
    assert {EventKind.FOLD, *STABILITY_LOSSES} <= event_kinds


@pytest.mark.parametrize(
    ("p", "options", "message"),
    [
        # By default the range ends at ten times μ.
        (Parameters(), {"low": 1.0}, "no Hopf point with mu from 1 to 7"),
        (Parameters(c1=0.0, c2=0.0), {}, "without damping"),
        (Parameters(F=0.0), {"low": 0.0, "high": 9.0}, "no verdict at F = 0"),
        (Parameters(mu=0.2), {"origin": "cycle"}, "no limit cycle was found from 11 starts"),
    ],
)
def test_without_a_start_of_a_branch_the_error_gives_the_reason(
    p: Parameters, options: dict[str, float], message: str
) -> None:
    with pytest.raises(ComputationError, match=message) as caught:
        branch(p, "mu", **options)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("p", "options", "message"),
    [
        (Parameters(), {"low": 2.0, "high": 1.0}, "must be a range of ascending values"),
        (Parameters(mu=0.0), {}, "must be above 0 unless the range is given"),
        (Parameters(), {"low": -1.0}, "must be from 0 to 100"),
        (Parameters(), {"origin": "file"}, "must be one of hopf, cycle, or a path"),
        (Parameters(), {"origin": "cycle", "low": 1.0}, "mu = 0.7: must be in the range 1 to 7"),
        (Parameters(k_nl=0.0), {"separation": False}, "k_nl = 0: must be above 0"),
    ],
)
def test_wrong_requests_give_an_error_of_one_line(
    p: Parameters, options: dict[str, float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        branch(p, "mu", **options)  # type: ignore[arg-type]

"""Branches of limit cycles: against closed forms, transients, and other integrators."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from fivtui import ComputationError, InputError, Parameters, branch, simulate, stability
from fivtui.equilibrium import critical_mu
from fivtui.model import System, accelerations, mode_of
from fivtui.orbits.boundaries.result import BoundaryPoint
from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.hopf import hopf_point, hopf_values
from fivtui.orbits.curves.result import CycleBranch, CyclePoint

# Hopf point, first touch of y = 0, fold and its period, computed by a prototype on another way.
KNOWN = {
    80.0: (0.439387619, 0.370729887, 0.277876613, 1.1945636),
    120.0: (0.762298519, 0.598203381, 0.277935093, 1.1945678),
}
LOSES = (EventKind.PERIOD_DOUBLING, EventKind.TORUS)


def values_of(found: CycleBranch, kind: EventKind) -> list[float]:
    return [event.value for event in found.events if event.kind is kind]


def point_at(found: CycleBranch, value: float) -> CyclePoint:
    return next(point for point in found.points if point.value == value)


def at(found: CycleBranch, value: float) -> Parameters:
    return found.parameters.with_values({found.name: value})


def drawn(count: int, seed: int) -> Iterator[Parameters]:
    random = np.random.default_rng(seed)
    for _ in range(count):
        low = [1.0, 50.0, 20.0, 20.0, 0.05, 0.05, 5.0, 1.0]
        high = [10.0, 300.0, 200.0, 150.0, 2.0, 2.0, 200.0, 500.0]
        names = ("m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl")
        yield Parameters(**dict(zip(names, random.uniform(low, high).tolist(), strict=True)))


@pytest.fixture(scope="module", params=KNOWN)
def known(request: pytest.FixtureRequest) -> CycleBranch:
    return branch(Parameters(F=request.param), "mu", low=0.0, high=1.2)


def test_the_branch_passes_lift_off_and_turns_at_the_known_fold(known: CycleBranch) -> None:
    kinds = [event.kind for event in known.events]
    assert kinds == [EventKind.HOPF, EventKind.TOUCH, EventKind.FOLD]
    *values, period = KNOWN[known.parameters.F]
    assert [event.value for event in known.events] == pytest.approx(values, abs=1e-8)
    assert known.events[-1].period == pytest.approx(period, abs=5e-8)
    assert known.events[0].direction == "subcritical"
    assert known.events[1].y_max == pytest.approx(0.0, abs=1e-11)
    assert known.ends == (End.EQUILIBRIUM, End.BOUND)
    assert known.points[-1].value == 1.2


def test_a_multiplier_is_one_at_the_fold_where_stability_changes(known: CycleBranch) -> None:
    (fold,) = values_of(known, EventKind.FOLD)
    place = known.points.index(point_at(known, fold))
    assert min(abs(value - 1.0) for value in known.points[place].multipliers) < 1e-6
    assert not any(point.stable for point in known.points[:place])
    assert all(point.stable for point in known.points[place + 1 :])


@pytest.mark.parametrize("change", [5e-5, 5e-6])
def test_the_fold_is_where_transients_stop_dying_out(known: CycleBranch, change: float) -> None:
    (fold,) = values_of(known, EventKind.FOLD)
    point = point_at(known, fold)
    kept, lost = (
        simulate(at(known, fold + way), t_end=20_000.0, start=point.start)
        for way in (change, -change)
    )
    assert kept.steady.y_half_range == pytest.approx(point.half_range, rel=0.2)
    assert lost.steady.y_half_range < 1e-6


def assert_closed(found: CycleBranch, point: CyclePoint) -> None:
    assert_closes(at(found, point.value), point, separation=found.separation)


def assert_closes(p: Parameters, point: CyclePoint | BoundaryPoint, *, separation: bool) -> None:
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


def test_cycles_close_under_another_integrator(known: CycleBranch) -> None:
    for point in known.points[5::20]:
        assert_closed(known, point)


def independent_multipliers(found: CycleBranch, point: CyclePoint) -> np.ndarray:
    """Multipliers across a cycle from differences of runs by SciPy."""
    p = at(found, point.value)
    speed = 2.0 * math.pi / point.period
    scales = np.array([1.0, speed, 1.0, speed]) * point.half_range

    def after(start: np.ndarray) -> np.ndarray:
        run = simulate(
            p,
            start=start.tolist(),
            separation=found.separation,
            method="scipy-dop853",
            tol=1e-12,
            t_end=point.period,
        )
        return np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])

    start = np.array(point.start)
    columns = [
        (after(start + step * scales) - after(start - step * scales)) / (2e-5 * scales)
        for step in 1e-5 * np.eye(4)
    ]
    ax, ay = accelerations(p, point.start, mode_of(p, point.start, separation=found.separation))
    rate = np.array([point.start[1], ax, point.start[3], ay]) / scales
    basis = np.linalg.qr(np.column_stack([rate, np.eye(4)]))[0][:, 1:4]
    return np.linalg.eigvals(basis.T @ np.array(columns).T @ basis)


def assert_folds_are_folds(p: Parameters) -> int:
    found = branch(p, "mu", low=0.0, high=10.0)
    folds = values_of(found, EventKind.FOLD)
    for fold in folds:
        point = point_at(found, fold)
        assert_closed(found, point)
        if abs(point.y_max) > 1e-3 * abs(point.y_min):
            # Near a touch differences are not derivatives.
            assert np.abs(independent_multipliers(found, point) - 1.0).min() < 1e-5
    return len(folds)


def test_folds_of_drawn_sets_are_folds_of_another_integrator() -> None:
    assert sum(map(assert_folds_are_folds, drawn(2, 11))) > 0


@pytest.mark.whole
def test_folds_of_ten_drawn_sets_are_folds_of_another_integrator() -> None:
    assert sum(assert_folds_are_folds(p) > 0 for p in drawn(25, 11)) >= 10


def test_the_product_of_the_multipliers_is_the_contraction_of_volume(known: CycleBranch) -> None:
    p = known.parameters
    for point in known.points:
        lost = math.exp(-(p.c1 + p.c2) / p.m * point.period)
        assert np.prod(point.multipliers) == pytest.approx(lost, rel=1e-7)


def test_from_a_cycle_the_same_branch_is_found_both_ways(known: CycleBranch) -> None:
    p = known.parameters.with_values({"mu": 0.8})
    found = branch(p, "mu", low=0.0, high=1.2, origin="cycle")
    assert found.ends == known.ends
    assert [event.kind for event in found.events] == [event.kind for event in known.events]
    for one, other in zip(found.events, known.events, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-10)
    assert point_at(found, 0.8).stable


def test_at_40_newtons_the_hopf_point_is_supercritical_and_cycles_begin_above_it() -> None:
    found = branch(Parameters(F=40.0), "mu", high=1.0)
    assert found.events[0].direction == "supercritical"
    assert found.points[0].stable
    assert found.points[0].value > found.events[0].value
    assert not values_of(found, EventKind.FOLD)


def test_at_30_newtons_two_folds_are_told_apart() -> None:
    found = branch(Parameters(F=30.0), "mu", low=0.3, high=0.6)
    assert [event.kind.value for event in found.events] == ["hopf", "fold", "touch", "fold"]
    upper, lower = values_of(found, EventKind.FOLD)
    assert lower < found.events[0].value < upper
    assert upper - lower < 3e-3
    # In between there are three cycles.
    middle = 0.5 * (upper + found.events[0].value)
    signs = np.sign([point.value - middle for point in found.points])
    assert np.count_nonzero(np.diff(signs)) == 3


def test_without_cubic_stiffness_all_cycles_in_contact_are_at_the_linear_boundary() -> None:
    found = branch(Parameters(k_nl=0.0), "mu", low=0.5, high=2.0)
    boundary = stability(Parameters(k_nl=0.0)).linear_critical_mu
    hopf, touch = found.events
    assert hopf.direction == "degenerate"
    assert touch.kind is EventKind.TOUCH
    assert touch.value == pytest.approx(boundary, abs=1e-9)


@pytest.mark.parametrize("k_nl", [1e-6, 1e-3])
def test_with_little_cubic_stiffness_touch_and_fold_are_told_apart(k_nl: float) -> None:
    for name, mu in (("mu", 0.7), ("c1", 0.95), ("k1", 1.0)):
        found = branch(Parameters(k_nl=k_nl, mu=mu), name)
        assert [event.kind.value for event in found.events] == ["hopf", "touch", "fold"]


def test_where_separation_is_ignored_nothing_touches() -> None:
    found = branch(None, "mu", high=2.0, separation=False)
    assert {event.kind for event in found.events} == {EventKind.HOPF, EventKind.FOLD}
    (fold,) = values_of(found, EventKind.FOLD)
    assert_closed(found, point_at(found, fold))


def test_a_branch_between_two_hopf_points_ends_at_both() -> None:
    found = branch(None, "k1")
    assert found.ends == (End.EQUILIBRIUM, End.EQUILIBRIUM)
    first, last = values_of(found, EventKind.HOPF)
    for value in (first, last):
        assert critical_mu(System(Parameters(k1=value)))[0].mu == pytest.approx(0.7, abs=1e-12)
    assert found.points[-1].half_range < 0.01
    assert found.points[-1].value == pytest.approx(last, abs=1e-3 * last)


@pytest.mark.parametrize("name", ["m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl"])
def test_hopf_points_along_any_parameter_are_those_of_the_closed_form(name: str) -> None:
    for drawn_set in drawn(6, 7):
        value = 1.3 * getattr(drawn_set, name)
        (critical,) = critical_mu(System(drawn_set.with_values({name: value})))
        p = drawn_set.with_values({"mu": critical.mu})
        found = hopf_values(System(p), name, value / 10.0, value * 10.0)
        assert min(abs(one - value) for one in found) < 1e-9 * value
        for one in found:
            there = critical_mu(System(p.with_values({name: one})))
            assert there[0].mu == pytest.approx(critical.mu, rel=1e-12)


def test_cycles_next_to_a_hopf_point_grow_as_the_lyapunov_coefficient_says() -> None:
    # Of the normal form: 0 = σ' (μ − μ_c) + l a²/4, with the amplitude a of y.
    for p in drawn(6, 3):
        (mu_c,) = hopf_values(System(p), "mu", 0.0, 100.0)
        hopf = hopf_point(System(p.with_values({"mu": mu_c})), "mu")
        rates = [stability(p.with_values({"mu": mu_c + d})).growth_rate for d in (1e-6, -1e-6)]
        first = branch(p, "mu", low=0.999 * mu_c, high=1.001 * mu_c).points[0]
        slope = (rates[0] - rates[1]) / 2e-6
        expected = -hopf.lyapunov * first.half_range**2 / (4.0 * slope)
        assert first.value - mu_c == pytest.approx(expected, rel=1e-3)
        assert first.period == pytest.approx(2.0 * np.pi / hopf.omega, rel=1e-4)


def assert_explained(p: Parameters) -> set[EventKind]:
    # Ends are reasons, and stability changes at events alone.
    found = branch(p, "mu", low=0.0, high=10.0)
    assert not {End.LOST, End.LONG} & set(found.ends)
    assert found.events[0].value == critical_mu(System(p))[0].mu
    rises = found.points[0].value > found.events[0].value
    assert found.points[0].stable == rises == (found.events[0].direction == "supercritical")
    events = {event.value: event.kind for event in found.events}
    for place, point in enumerate(found.points[1:-1], start=1):
        before, after = found.points[place - 1], found.points[place + 1]
        kind = events.get(point.value)
        if kind is None:
            assert point.stable in (before.stable, after.stable)
            continue
        assert_closed(found, point)
        sizes = np.abs(point.multipliers)
        if kind is EventKind.FOLD:
            assert (point.value - before.value) * (after.value - point.value) < 0.0
            assert min(abs(value - 1.0) for value in point.multipliers) < 1e-6
        if kind is EventKind.PERIOD_DOUBLING:
            assert min(abs(value + 1.0) for value in point.multipliers) < 1e-6
        if kind is EventKind.TORUS:
            turning = np.abs(np.imag(point.multipliers)) > 1e-6
            assert np.abs(sizes[turning] - 1.0).max() < 1e-6
    changes = sum(
        one.stable != other.stable
        for one, other in zip(found.points, found.points[1:], strict=False)
        if not {one.value, other.value} & events.keys()
    )
    assert changes == 0
    return set(events.values())


def test_branches_of_drawn_sets_are_explained() -> None:
    met = set[EventKind]().union(*map(assert_explained, drawn(8, 5)))
    assert {EventKind.FOLD, EventKind.PERIOD_DOUBLING} <= met


@pytest.mark.whole
def test_branches_of_many_drawn_sets_are_explained() -> None:
    met = set[EventKind]().union(*map(assert_explained, drawn(60, 5)))
    assert {EventKind.FOLD, *LOSES} <= met


@pytest.mark.parametrize(
    ("p", "options", "said"),
    [
        (Parameters(), {"low": 1.0}, "no Hopf point with mu from 1 to 7"),
        (Parameters(c1=0.0, c2=0.0), {}, "without damping"),
        (Parameters(F=0.0), {"low": 0.0, "high": 9.0}, "the equilibrium is at y = 0"),
        (Parameters(mu=0.2), {"origin": "cycle"}, "no limit cycle was found from 11 starts"),
    ],
)
def test_where_nothing_begins_one_line_says_why(
    p: Parameters, options: dict[str, float], said: str
) -> None:
    with pytest.raises(ComputationError, match=said) as caught:
        branch(p, "mu", **options)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("p", "options", "said"),
    [
        (Parameters(), {"low": 2.0, "high": 1.0}, "must be a range of ascending values"),
        (Parameters(mu=0.0), {}, "must be above 0, or the range be given"),
        (Parameters(), {"low": -1.0}, "must be from 0 to 100"),
        (Parameters(), {"origin": "file"}, "must be one of hopf, cycle, or a path"),
        (Parameters(), {"origin": "cycle", "low": 1.0}, "mu = 0.7: must be in the range 1 to 7"),
        (Parameters(k_nl=0.0), {"separation": False}, "k_nl = 0: must be above 0"),
    ],
)
def test_what_is_wrong_with_the_question_is_said_in_one_line(
    p: Parameters, options: dict[str, float], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        branch(p, "mu", **options)  # type: ignore[arg-type]

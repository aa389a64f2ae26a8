"""Curves over two parameters: against closed forms, branches, and other integrators."""

from functools import cache

import numpy as np
import pytest

from fivtui import Cancelled, ComputationError, InputError, Parameters, boundary, branch
from fivtui.equilibrium import critical_mu
from fivtui.model import System
from fivtui.orbits.boundaries.result import (
    BOUNDARIES,
    Boundary,
    BoundaryCurve,
    BoundaryKind,
    BoundaryPoint,
)
from fivtui.orbits.curves.events import End, EventKind
from tests.orbits.curves.test_cycle_branches import assert_orbit_closes, random_sets

BASE = Parameters()
NARROW = {"F": (24.0, 60.0), "mu": (0.2, 0.8)}


@cache
def narrow_boundary(kind: BoundaryKind) -> Boundary:
    return boundary(Parameters(F=30.0), kind, NARROW)


def parameters_at(result: Boundary, point: BoundaryPoint) -> Parameters:
    return result.parameters.with_values(dict(zip(result.names, point.values, strict=True)))


def interpolate_points(
    curve: BoundaryCurve, column: int, value: float
) -> list[tuple[float, float]]:
    """Points where the polygon through a curve's points crosses a value of one parameter."""
    crossings = []
    for first, second in zip(curve.points, curve.points[1:], strict=False):
        begin, end = first.values[column], second.values[column]
        if min(begin, end) <= value < max(begin, end):
            share = (value - begin) / (end - begin)
            values = [a + share * (b - a) for a, b in zip(first.values, second.values, strict=True)]
            crossings.append((values[0], values[1]))
    return crossings


def values_of(result: Boundary, kind: EventKind) -> list[tuple[float, float]]:
    return sorted(event.values for event in result.events if event.kind is kind)


def test_the_two_folds_at_30_newtons_meet_at_a_cusp() -> None:
    result = narrow_boundary("fold")
    (cusp,) = values_of(result, EventKind.CUSP)
    assert cusp == pytest.approx((36.510164339, 0.321049647), abs=1e-8)
    curve = next(c for c in result.curves if cusp in [event.values for event in c.events])
    # One side of the cusp has two folds, the other none.
    assert len(interpolate_points(curve, 0, 30.0)) == 2
    assert max(point.values[0] for point in curve.points) == cusp[0]
    events = branch(Parameters(F=30.0), "mu", low=0.3, high=0.6).events
    expected = sorted(event.value for event in events if event.kind is EventKind.FOLD)
    assert sorted(mu for _, mu in interpolate_points(curve, 0, 30.0)) == pytest.approx(
        expected, abs=1e-4
    )
    assert not [
        event
        for event in branch(Parameters(F=cusp[0] + 0.05), "mu", low=0.25, high=0.6).events
        if event.kind is EventKind.FOLD
    ]


def test_curves_of_folds_and_of_touching_cycles_meet_where_a_cycle_is_both() -> None:
    folds, touches = narrow_boundary("fold"), narrow_boundary("touch")
    # Here the cycle at the cusp, too, just reaches y = 0.
    touching_folds = values_of(folds, EventKind.CUSP) + values_of(folds, EventKind.TOUCH)
    assert len(touching_folds) == 2
    np.testing.assert_allclose(values_of(touches, EventKind.FOLD), touching_folds, rtol=1e-9)


def test_folds_begin_where_hopf_points_turn_subcritical() -> None:
    folds, hopfs = narrow_boundary("fold"), narrow_boundary("hopf")
    bautin = values_of(hopfs, EventKind.BAUTIN)
    assert len(bautin) == 2
    np.testing.assert_allclose(values_of(folds, EventKind.BAUTIN), bautin, rtol=1e-7)
    for force, _ in bautin:
        kinds = {
            branch(Parameters(F=force + change), "mu", low=0.2, high=0.8).events[0].direction
            for change in (-0.5, 0.5)
        }
        assert kinds == {"supercritical", "subcritical"}


def test_hopf_points_are_those_of_the_closed_form() -> None:
    for result in (
        narrow_boundary("hopf"),
        boundary(BASE, "hopf", {"k1": (20.0, 300.0), "c1": (0.05, 2.0)}),
    ):
        for point in result.points[::4]:
            p = parameters_at(result, point)
            (critical,) = critical_mu(System(p))
            assert critical.mu == pytest.approx(p.mu, rel=1e-12)
    point = narrow_boundary("hopf").points[0]
    assert point.lyapunov != 0.0
    assert not point.multipliers


def assert_cycle_closes(result: Boundary, point: BoundaryPoint) -> None:
    assert_orbit_closes(parameters_at(result, point), point, separation=result.separation)


def assert_multiplier_one_at_folds(result: Boundary) -> None:
    for point in result.points:
        assert point.multipliers or point.values in values_of(result, EventKind.BAUTIN)
        assert min((abs(value - 1.0) for value in point.multipliers), default=0.0) < 1e-6


PAIRS = [
    ("F", (60.0, 150.0), "mu", (0.1, 0.6)),
]
MORE_PAIRS = [
    ("k2", (20.0, 300.0), "k3", (30.0, 100.0)),
    ("F", (20.0, 150.0), "k_nl", (20.0, 500.0)),
    ("c1", (0.1, 0.6), "mu", (0.1, 1.0)),
    ("c2", (0.1, 0.6), "mu", (0.1, 1.0)),
    ("k1", (60.0, 140.0), "mu", (0.1, 1.5)),
]
SLOW_PAIRS = [pytest.param(*pair, marks=pytest.mark.whole) for pair in MORE_PAIRS]


@pytest.mark.parametrize(
    ("first_name", "first_range", "second_name", "second_range"), [*PAIRS, *SLOW_PAIRS]
)
def test_a_fold_has_a_multiplier_1_and_closes_under_another_integrator(
    first_name: str,
    first_range: tuple[float, float],
    second_name: str,
    second_range: tuple[float, float],
) -> None:
    result = boundary(None, "fold", {first_name: first_range, second_name: second_range})
    assert result.warning is None
    assert_multiplier_one_at_folds(result)
    for point in result.points:
        assert first_range[0] <= point.values[0] <= first_range[1]
        assert second_range[0] <= point.values[1] <= second_range[1]
    for point in result.points[:: max(1, len(result.points) // 2)]:
        assert_cycle_closes(result, point)


def test_the_curve_of_folds_has_the_folds_of_the_branches() -> None:
    result = boundary(None, "fold", {"F": (60.0, 150.0), "mu": (0.1, 0.6)})
    (curve,) = result.curves
    # It leaves the range at both ends.
    assert curve.ends == (End.BOUND, End.BOUND)
    for point in curve.points[::16]:
        events = branch(Parameters(F=point.values[0]), "mu", low=0.2, high=1.2).events
        (fold,) = (event for event in events if event.kind is EventKind.FOLD)
        assert fold.value == pytest.approx(point.values[1], abs=1e-10)
        assert fold.period == pytest.approx(point.period, abs=1e-7)


def test_touching_cycles_are_the_touches_of_the_branches() -> None:
    result = narrow_boundary("touch")
    assert max(abs(point.y_max) for point in result.points) < 1e-9
    for point in result.points[::20]:
        events = branch(Parameters(F=point.values[0]), "mu", low=0.2, high=0.9).events
        (touch,) = (event for event in events if event.kind is EventKind.TOUCH)
        assert touch.value == pytest.approx(point.values[1], abs=1e-10)
        assert_cycle_closes(result, point)


@pytest.mark.whole
def test_curves_of_random_sets_are_not_lost() -> None:
    # Over any two parameters each curve leaves the range, ends in the equilibrium or is closed, and
    # each fold has the multiplier 1.
    random, boundary_count = np.random.default_rng(3), 0
    for p in random_sets(count=40, seed=9):
        (critical,) = critical_mu(System(p))
        shifted = p.with_values({"mu": critical.mu * random.uniform(0.7, 1.2)})
        names = ("F", "mu", "k_nl", "k1", "k2", "k3", "c1", "c2")
        first_name, second_name = (str(name) for name in random.choice(names, 2, replace=False))
        over = {
            name: (0.4 * getattr(shifted, name), 2.0 * getattr(shifted, name))
            for name in (first_name, second_name)
        }
        for kind in BOUNDARIES:
            try:
                result = boundary(shifted, kind, over)
            except ComputationError:
                continue
            boundary_count += 1
            for curve in result.curves:
                assert set(curve.ends) <= {End.BOUND, End.EQUILIBRIUM, End.CLOSED}
            if kind == "fold":
                assert_multiplier_one_at_folds(result)
    assert boundary_count > 80


def test_where_separation_is_ignored_no_cycle_of_a_fold_touches() -> None:
    result = boundary(None, "fold", {"F": (70.0, 90.0), "mu": (0.1, 1.5)}, separation=False)
    assert {event.kind for event in result.events} <= {EventKind.CUSP, EventKind.BAUTIN}
    assert_cycle_closes(result, result.points[len(result.points) // 2])


def test_a_result_prints_its_events() -> None:
    assert "cusp" in repr(narrow_boundary("fold"))


def test_cycles_have_no_lyapunov_coefficient() -> None:
    result = narrow_boundary("fold")
    # Only the Hopf points at which curves of folds begin have no multipliers.
    is_cycle = [bool(point.multipliers) for point in result.points]
    assert np.isnan(result.to_columns()["lyapunov"][is_cycle]).all()


def test_missing_folds_and_cancellation_raise_errors() -> None:
    with pytest.raises(ComputationError, match="no fold was found over F and mu"):
        boundary(None, "fold", {"F": (60.0, 80.0), "mu": (0.05, 0.1)})
    with pytest.raises(Cancelled):
        boundary(None, "fold", NARROW, progress=lambda fraction: fraction < 0.2)


def test_a_belt_of_finite_speed_is_refused() -> None:
    with pytest.raises(
        InputError, match="v_belt = 1: must be none for boundaries; follow branches"
    ):
        boundary(Parameters(v_belt=1.0), "fold", NARROW)


@pytest.mark.parametrize(
    ("kind", "over", "separation", "message"),
    [
        ("torus", NARROW, True, "must be one of hopf, fold, touch"),
        ("fold", {"F": (1.0, 2.0)}, True, "over: F; must be two parameters"),
        ("fold", {"F": (2.0, 1.0), "mu": None}, True, "must be a range of ascending values"),
        ("fold", {"f": (1.0, 2.0), "mu": None}, True, "unknown parameter 'f'"),
        ("touch", NARROW, False, "separation must be considered"),
    ],
)
def test_wrong_requests_give_an_error_of_one_line(
    kind: BoundaryKind, over: dict[str, tuple[float, float]], separation: bool, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        boundary(None, kind, over, separation=separation)

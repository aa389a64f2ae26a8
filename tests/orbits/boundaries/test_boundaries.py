"""Curves over two parameters: against closed forms, branches, and other integrators."""

import math
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
from tests.orbits.curves.test_cycle_branches import assert_closes, drawn

BASE = Parameters()
NARROW = {"F": (24.0, 60.0), "mu": (0.2, 0.8)}


@cache
def narrow(kind: BoundaryKind) -> Boundary:
    return boundary(Parameters(F=30.0), kind, NARROW)


def at(found: Boundary, point: BoundaryPoint) -> Parameters:
    return found.parameters.with_values(dict(zip(found.names, point.values, strict=True)))


def crossing(curve: BoundaryCurve, place: int, value: float) -> list[tuple[float, float]]:
    """Where straight lines between the points of a curve reach a value of one parameter."""
    found = []
    for one, other in zip(curve.points, curve.points[1:], strict=False):
        begin, end = one.values[place], other.values[place]
        if min(begin, end) <= value < max(begin, end):
            share = (value - begin) / (end - begin)
            values = [a + share * (b - a) for a, b in zip(one.values, other.values, strict=True)]
            found.append((values[0], values[1]))
    return found


def values_of(found: Boundary, kind: EventKind) -> list[tuple[float, float]]:
    return sorted(event.values for event in found.events if event.kind is kind)


def test_the_two_folds_at_30_newtons_meet_at_a_cusp() -> None:
    found = narrow("fold")
    (cusp,) = values_of(found, EventKind.CUSP)
    assert cusp == pytest.approx((36.510164339, 0.321049647), abs=1e-8)
    curve = next(c for c in found.curves if cusp in [event.values for event in c.events])
    # On one side of it two folds, on the other none.
    assert len(crossing(curve, 0, 30.0)) == 2
    assert max(point.values[0] for point in curve.points) == cusp[0]
    events = branch(Parameters(F=30.0), "mu", low=0.3, high=0.6).events
    expected = sorted(event.value for event in events if event.kind is EventKind.FOLD)
    assert sorted(mu for _, mu in crossing(curve, 0, 30.0)) == pytest.approx(expected, abs=1e-4)
    assert not [
        event
        for event in branch(Parameters(F=cusp[0] + 0.05), "mu", low=0.25, high=0.6).events
        if event.kind is EventKind.FOLD
    ]


def test_folds_touch_where_touching_cycles_are_folds() -> None:
    folds, touches = narrow("fold"), narrow("touch")
    corners = values_of(folds, EventKind.CUSP) + values_of(folds, EventKind.TOUCH)
    assert len(corners) == 2
    np.testing.assert_allclose(values_of(touches, EventKind.FOLD), corners, rtol=1e-9)


def test_folds_begin_where_hopf_points_turn_subcritical() -> None:
    folds, hopfs = narrow("fold"), narrow("hopf")
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
    for found in (narrow("hopf"), boundary(BASE, "hopf", {"k1": (20.0, 300.0), "c1": (0.05, 2.0)})):
        for point in found.points[::4]:
            p = at(found, point)
            (critical,) = critical_mu(System(p))
            assert critical.mu == pytest.approx(p.mu, rel=1e-12)
    point = narrow("hopf").points[0]
    assert point.lyapunov != 0.0
    assert not point.multipliers


def assert_closed(found: Boundary, point: BoundaryPoint) -> None:
    assert_closes(at(found, point), point, separation=found.separation)


def assert_folds(found: Boundary) -> None:
    for point in found.points:
        assert point.multipliers or point.values in values_of(found, EventKind.BAUTIN)
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
WHOLE = [pytest.param(*pair, marks=pytest.mark.whole) for pair in MORE_PAIRS]


@pytest.mark.parametrize(("one", "range_of_one", "other", "range_of_other"), [*PAIRS, *WHOLE])
def test_a_fold_has_a_multiplier_1_and_closes_under_another_integrator(
    one: str, range_of_one: tuple[float, float], other: str, range_of_other: tuple[float, float]
) -> None:
    found = boundary(None, "fold", {one: range_of_one, other: range_of_other})
    assert found.warning is None
    assert_folds(found)
    for point in found.points:
        assert range_of_one[0] <= point.values[0] <= range_of_one[1]
        assert range_of_other[0] <= point.values[1] <= range_of_other[1]
    for point in found.points[:: max(1, len(found.points) // 2)]:
        assert_closed(found, point)


def test_the_curve_of_folds_has_those_of_the_branches() -> None:
    found = boundary(None, "fold", {"F": (60.0, 150.0), "mu": (0.1, 0.6)})
    (curve,) = found.curves
    assert curve.ends == (End.BOUND, End.BOUND)
    for point in curve.points[::16]:
        events = branch(Parameters(F=point.values[0]), "mu", low=0.2, high=1.2).events
        (fold,) = (event for event in events if event.kind is EventKind.FOLD)
        assert fold.value == pytest.approx(point.values[1], abs=1e-10)
        assert fold.period == pytest.approx(point.period, abs=1e-7)


def test_touching_cycles_are_those_of_the_branches() -> None:
    found = narrow("touch")
    assert max(abs(point.y_max) for point in found.points) < 1e-9
    for point in found.points[::20]:
        events = branch(Parameters(F=point.values[0]), "mu", low=0.2, high=0.9).events
        (touch,) = (event for event in events if event.kind is EventKind.TOUCH)
        assert touch.value == pytest.approx(point.values[1], abs=1e-10)
        assert_closed(found, point)


@pytest.mark.whole
def test_curves_of_drawn_sets_end_where_there_is_a_reason() -> None:
    # In any two parameters; no curve is lost, and every fold is one.
    random, met = np.random.default_rng(3), 0
    for p in drawn(40, 9):
        (critical,) = critical_mu(System(p))
        there = p.with_values({"mu": critical.mu * random.uniform(0.7, 1.2)})
        names = ("F", "mu", "k_nl", "k1", "k2", "k3", "c1", "c2")
        one, other = (str(name) for name in random.choice(names, 2, replace=False))
        over = {n: (0.4 * getattr(there, n), 2.0 * getattr(there, n)) for n in (one, other)}
        for kind in BOUNDARIES:
            try:
                found = boundary(there, kind, over)
            except ComputationError:
                continue
            met += 1
            for curve in found.curves:
                assert set(curve.ends) <= {End.BOUND, End.EQUILIBRIUM, End.CLOSED}
            if kind == "fold":
                assert_folds(found)
    assert met > 80


def test_where_separation_is_ignored_folds_have_no_corners() -> None:
    found = boundary(None, "fold", {"F": (70.0, 90.0), "mu": (0.1, 1.5)}, separation=False)
    assert {event.kind for event in found.events} <= {EventKind.CUSP, EventKind.BAUTIN}
    assert_closed(found, found.points[len(found.points) // 2])


def test_a_result_prints_its_events() -> None:
    assert "cusp" in repr(narrow("fold"))
    assert math.isnan(narrow("fold").to_columns()["lyapunov"][5])


def test_what_is_not_there_is_said() -> None:
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
    ("kind", "over", "separation", "said"),
    [
        ("torus", NARROW, True, "must be one of hopf, fold, touch"),
        ("fold", {"F": (1.0, 2.0)}, True, "1 parameters are given; must be two"),
        ("fold", {"F": (2.0, 1.0), "mu": None}, True, "must be a range of ascending values"),
        ("fold", {"f": (1.0, 2.0), "mu": None}, True, "unknown parameter 'f'"),
        ("touch", NARROW, False, "separation must be considered"),
    ],
)
def test_what_is_wrong_with_the_question_is_said_in_one_line(
    kind: BoundaryKind, over: dict[str, tuple[float, float]], separation: bool, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        boundary(None, kind, over, separation=separation)

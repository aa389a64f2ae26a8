"""Curves that are known are followed to their ends, and their folds located."""

import numpy as np
import pytest

from fivtui.model.parameters import Parameters
from fivtui.orbits.curves.arclength import PERIOD, VALUE, FloatArray, OrbitCurve, OrbitOnCurve
from fivtui.orbits.curves.following import End, EventKind, Followed, Follower
from fivtui.transient.derivatives.variation import Variation


class Circle(OrbitCurve):
    """A circle of orbits in the plane of period and parameter, about (3, 2), of radius 1."""

    def __init__(self) -> None:
        super().__init__(Parameters(), "mu", np.ones(6))

    def from_rest(self, unknowns: FloatArray) -> float:
        return 1.0

    def solve(
        self,
        guess: FloatArray,
        across: FloatArray,
        along: FloatArray,
        tangent: FloatArray | None = None,
    ) -> OrbitOnCurve | None:
        unknowns = guess.copy()
        for _ in range(20):
            radius = unknowns[PERIOD:] - (3.0, 2.0)
            missed = np.array([radius @ radius - 1.0, along @ (unknowns - guess)])
            if np.abs(missed).max() < 1e-14:
                break
            slope = np.array([2.0 * radius, along[PERIOD:]])
            unknowns[PERIOD:] -= np.linalg.solve(slope, missed)
        else:
            return None
        way = np.zeros(6)
        way[PERIOD:] = (-radius[1], radius[0])
        way *= np.sign(way @ (along if tangent is None else tangent))
        none = np.zeros(0)
        extremes = np.array([-1.0, 1.0, -2.0, -1.0, 1.0, -2.0, -1.0])
        flow = Variation((0.0,) * 4, none, none, none, extremes, none, none, none, none)
        return OrbitOnCurve(unknowns, flow, across, way, 0.5 * np.eye(3), 1.0, 1)


def follow(angle: float, low: float, high: float) -> Followed:
    circle = Circle()
    way = np.zeros(6)
    way[PERIOD:] = (-np.sin(angle), np.cos(angle))
    start = circle.solve(
        np.array([0.0] * 4 + [3.0 + np.cos(angle), 2.0 + np.sin(angle)]), np.zeros(6), way
    )
    assert start is not None
    follower = Follower(circle, low, high, 0.1, lambda _count: None, touches=True)
    return follower.follow(start)


def test_a_closed_curve_ends_where_it_began_with_its_two_folds_located() -> None:
    found = follow(0.3, 0.0, 4.0)
    assert found.end is End.CLOSED
    assert set(found.events.values()) == {EventKind.FOLD}
    folds = [found.orbits[place].unknowns for place in found.events]
    assert [fold[VALUE] for fold in folds] == pytest.approx([3.0, 1.0], abs=1e-12)
    assert [fold[PERIOD] for fold in folds] == pytest.approx([3.0, 3.0], abs=2e-9)
    last = found.orbits[-1].unknowns[PERIOD:]
    assert last.tolist() == pytest.approx([3.0 + np.cos(0.3), 2.0 + np.sin(0.3)])


def test_a_curve_ends_at_the_bound_of_the_parameter() -> None:
    found = follow(0.3, 1.5, 4.0)
    assert found.end is End.BOUND
    assert found.orbits[-1].unknowns[VALUE] == 1.5
    assert found.orbits[-1].unknowns[PERIOD] == pytest.approx(3.0 - np.sqrt(0.75))
    assert list(found.events.values()) == [EventKind.FOLD]


def test_a_curve_that_begins_at_the_bound_and_leaves_has_no_more_points() -> None:
    assert follow(0.0, 0.0, 2.0) == Followed((), {}, End.BOUND)

"""Continuation of curves in closed form: their ends and their folds."""

import numpy as np
import pytest

from fivtui.orbits.curves.events import End, EventKind
from fivtui.orbits.curves.flow import FloatArray
from fivtui.orbits.curves.following import Bound, Curve, CurvePart, Follower, PointOnCurve

PERIOD, VALUE = 0, 1


class Circle(Curve[PointOnCurve]):
    """A circle in the plane of period and parameter, about (3, 2), of radius 1."""

    # Steps that may pass two folds at once are shortened.
    checks_hidden_folds = True

    def __init__(self, low: float, high: float) -> None:
        self.bounds = (Bound(VALUE, low, high),)
        # At a fold the parameter turns back: its derivative along the curve changes its sign.
        self.tests = {EventKind.FOLD: lambda point: float(point.tangent[VALUE])}

    def correct(
        self,
        guess: FloatArray,
        neighbour: PointOnCurve,
        normal: FloatArray,
        heading: FloatArray | None = None,
    ) -> PointOnCurve | None:
        # The point is in the plane through the guess with this normal. Its tangent points to the
        # side of `heading`, by default of the normal.
        unknowns = guess.copy()
        for _ in range(20):
            radius = unknowns - (3.0, 2.0)
            residuals = np.array([radius @ radius - 1.0, normal @ (unknowns - guess)])
            if np.abs(residuals).max() < 1e-14:
                break
            unknowns -= np.linalg.solve(np.array([2.0 * radius, normal]), residuals)
        else:
            return None
        tangent = np.array([-radius[1], radius[0]])
        tangent *= np.sign(tangent @ (normal if heading is None else heading))
        return PointOnCurve(unknowns, tangent, iterations=1)


def follow(angle: float, low: float, high: float) -> CurvePart[PointOnCurve]:
    """The circle from the point at an angle, rad, with the parameter from `low` to `high`."""
    radius = np.array([np.cos(angle), np.sin(angle)])
    tangent = np.array([-radius[1], radius[0]])
    start = PointOnCurve(np.array([3.0, 2.0]) + radius, tangent, iterations=1)
    return Follower(Circle(low, high), min_size=0.1).follow(start)


def test_a_closed_curve_ends_where_it_began_with_its_two_folds_located() -> None:
    curve = follow(0.3, 0.0, 4.0)
    assert curve.end is End.CLOSED
    assert set(curve.events.values()) == {EventKind.FOLD}
    folds = [curve.points[index].unknowns for index in curve.events]
    assert [fold[VALUE] for fold in folds] == pytest.approx([3.0, 1.0], abs=1e-12)
    assert [fold[PERIOD] for fold in folds] == pytest.approx([3.0, 3.0], abs=2e-9)
    end = curve.points[-1].unknowns
    assert end.tolist() == pytest.approx([3.0 + np.cos(0.3), 2.0 + np.sin(0.3)])


def test_a_curve_ends_at_the_bound_of_the_parameter() -> None:
    curve = follow(0.3, 1.5, 4.0)
    assert curve.end is End.BOUND
    assert curve.points[-1].unknowns[VALUE] == 1.5
    assert curve.points[-1].unknowns[PERIOD] == pytest.approx(3.0 - np.sqrt(0.75))
    assert list(curve.events.values()) == [EventKind.FOLD]


def test_a_curve_that_leaves_the_range_at_its_start_has_no_more_points() -> None:
    assert follow(0.0, 0.0, 2.0) == CurvePart((), {}, End.BOUND)

"""Metadata and marks in files and figures of branches, boundaries and continuations.

At the event touch of a branch the limit cycle just reaches y = 0, where the slider leaves the belt.
"""

import dataclasses
import math

import numpy as np
import pytest

from fivtui import boundary, branch
from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.orbits.attractor_continuation import KINDS, BranchPoint, Continuation
from fivtui.orbits.boundaries.result import Boundary
from fivtui.orbits.curves.events import End
from fivtui.orbits.explorer import Attractor, Kind


@pytest.fixture(scope="module")
def folds() -> Boundary:
    return boundary(Parameters(F=30.0), "fold", {"F": (28.0, 40.0), "mu": (0.2, 0.6)})


def test_attractors_without_an_orbit_have_no_orbit_columns() -> None:
    rest = BranchPoint(0.3, ("up", "down"), Attractor(Kind.EQUILIBRIUM))
    unsettled = BranchPoint(0.7, ("up",), Attractor(Kind.UNSETTLED))
    values = np.array([0.3, 0.7])
    columns = Continuation(System(Parameters()), "mu", values, (rest, unsettled)).to_columns()
    assert columns.pop("kind").tolist() == ["equilibrium", "not settled"]
    assert columns.pop("mu").tolist() == [0.3, 0.7]
    assert columns.pop("up").tolist() == [1, 1]
    assert columns.pop("down").tolist() == [1, 0]
    # An equilibrium has no orbit; its amplitude is zero.
    rest_size, unsettled_size = columns.pop("half_range").tolist()
    assert rest_size == 0.0
    assert math.isnan(unsettled_size)
    assert len(columns) == 9
    for name, numbers in columns.items():
        assert np.isnan(numbers).all(), name


def test_kinds_of_attractors_have_the_names_used_in_files() -> None:
    # At rest by stick the slider sticks for ever to a belt at rest.
    assert [str(kind) for kind in KINDS] == [
        "equilibrium",
        "contact limit cycle",
        "separating limit cycle",
        "unbounded",
        "not settled",
        "stick-slip limit cycle",
        "rest by stick",
    ]


def test_curves_have_their_events_and_ends(folds: Boundary) -> None:
    header, data = folds._header(), folds.to_dict()
    assert header["curve_events"] == ["cusp"]
    assert header["curve_event_values"] == [list(folds.events[0].values)]
    assert "F" not in header["parameters"]
    assert [axis["name"] for axis in data["over"]] == ["F", "mu"]
    (curve,) = data["curves"]
    assert curve["events"][0]["kind"] == "cusp"
    assert len(curve["points"]) == len(folds.points)
    assert {"values", "period", "y_min", "y_max", "start", "multipliers"} <= set(curve["points"][0])
    assert len(curve["ends"]) == 2


def test_curves_are_drawn_in_the_plane_of_the_parameters(folds: Boundary) -> None:
    (axes,) = folds.figure().axes
    lines = {str(line.get_label()): line for line in axes.lines}
    assert set(lines) == {"folds", "cusp"}
    np.testing.assert_array_equal(
        np.array(lines["folds"].get_data()).T, [point.values for point in folds.points]
    )
    assert np.array(lines["cusp"].get_data())[:, 0].tolist() == list(folds.events[0].values)


def test_a_branch_has_its_events_at_their_cycles() -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    columns, header = result.to_columns(), result._header()
    # The column is 0 at points without an event, else the index of its kind.
    kind_indices = columns["event"][columns["event"] != 0]
    kinds = [header["event_kinds"][index] for index in kind_indices]
    assert kinds == ["touch", "fold"]
    assert header["events"] == ["hopf, subcritical", *kinds]
    assert header["event_periods"] == [event.period for event in result.events]
    _hopf_mu, _touch_mu, fold_mu = header["event_values"]
    (fold_index,) = np.flatnonzero(columns["mu"] == fold_mu)
    _, _, third_multiplier = result.points[fold_index].multipliers
    assert third_multiplier.real == columns["multiplier_3_re"][fold_index]


def test_a_branch_is_drawn_full_where_it_is_stable_and_dashed_where_it_is_not() -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    axes, orbits, multipliers = result.figure().axes
    lines = {str(line.get_label()): line for line in axes.lines if str(line.get_label())[0] != "_"}
    assert set(lines) == {"unstable", "stable", "hopf", "touch", "fold"}
    fold = result.events[-1].value
    drawn_count = 0
    for name, style in (("stable", "-"), ("unstable", "--")):
        line = lines[name]
        assert line.get_linestyle() == style
        cycles = {(p.value, p.half_range) for p in result.points if p.stable == (name == "stable")}
        drawn_points = set(zip(*np.array(line.get_data()).tolist(), strict=True))
        assert {cycle_point for cycle_point in cycles if cycle_point[0] != fold} <= drawn_points
        assert fold in {value for value, _ in drawn_points}
        drawn_count += len(drawn_points)
    # Stability changes at the fold, which is drawn in both lines.
    assert drawn_count == len(result.points) + 1
    for event in result.events:
        x, y = np.array(lines[str(event.kind)].get_data())[:, 0].tolist()
        assert (x, y) == (event.value, 0.5 * (event.y_max - event.y_min))
    for event in result.events[1:]:
        (orbit,) = (
            line for line in orbits.lines if f"= {event.value:.4g}" in str(line.get_label())
        )
        heights = np.array(orbit.get_xdata())
        assert [heights.min(), heights.max()] == pytest.approx([event.y_min, event.y_max], abs=1e-3)
        assert heights[0] == pytest.approx(heights[-1], abs=1e-5)
    all_multipliers = [value for point in result.points for value in point.multipliers]
    parts = [np.array(line.get_data()) for line in multipliers.lines[1:]]
    drawn_multipliers = [complex(x, y) for part in parts for x, y in part.T.tolist()]
    assert sorted(drawn_multipliers, key=abs) == sorted(all_multipliers, key=abs)


def test_a_figure_is_twice_as_high_as_the_largest_stable_cycle() -> None:
    result = branch(None, "mu")
    assert max(point.half_range for point in result.points) > 1000.0
    stable = max(point.half_range for point in result.points if point.stable)
    axes = result.figure().axes[0]
    assert axes.get_ylim() == pytest.approx((-0.1 * stable, 2.1 * stable))


def test_a_branch_that_could_not_be_followed_has_a_warning() -> None:
    complete = branch(None, "mu", low=0.25, high=0.6)
    assert complete.warning is None
    lost_branch = dataclasses.replace(complete, ends=(complete.ends[0], End.LOST))
    assert lost_branch.warning == "the branch cannot be followed farther at mu = 0.6"

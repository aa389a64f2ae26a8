"""Curves over two parameters in a file and in a figure."""

from pathlib import Path

import numpy as np
import pytest

from fivtui import Parameters, boundary
from fivtui.io.tables import read_header
from fivtui.orbits.boundaries.result import Boundary
from fivtui.results.tables import save_result


@pytest.fixture(scope="module")
def result() -> Boundary:
    return boundary(Parameters(F=30.0), "fold", {"F": (28.0, 40.0), "mu": (0.2, 0.6)})


def test_curves_in_a_file_have_their_events(result: Boundary, tmp_path: Path) -> None:
    save_result(result, tmp_path / "b.csv")
    header = read_header(tmp_path / "b.csv", "boundary")
    assert header["curve_events"] == ["cusp"]
    assert header["curve_event_values"] == [list(result.events[0].values)]
    assert "F" not in header["parameters"]


def test_curves_as_json_have_points_events_and_ends(result: Boundary) -> None:
    data = result.to_dict()
    assert [each["name"] for each in data["over"]] == ["F", "mu"]
    (curve,) = data["curves"]
    assert curve["events"][0]["kind"] == "cusp"
    assert len(curve["points"]) == len(result.points)
    assert {"values", "period", "y_min", "y_max", "start", "multipliers"} <= set(curve["points"][0])
    assert len(curve["ends"]) == 2


def test_curves_are_drawn_in_the_plane_of_the_parameters(result: Boundary) -> None:
    (axes,) = result.figure().axes
    lines = {str(line.get_label()): line for line in axes.lines}
    assert set(lines) == {"folds", "cusp"}
    np.testing.assert_array_equal(
        np.array(lines["folds"].get_data()).T, [point.values for point in result.points]
    )
    assert np.array(lines["cusp"].get_data())[:, 0].tolist() == list(result.events[0].values)

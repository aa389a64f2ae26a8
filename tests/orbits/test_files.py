"""A continuation in a file: what has no orbit has no numbers, and every column says what it is."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from fivtui import branch
from fivtui.io.tables import read_columns, read_header
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.orbits.branches import BranchPoint, Continuation
from fivtui.orbits.explorer import Attractor, Kind
from fivtui.orbits.figure import branch_figure
from fivtui.orbits.files import KINDS, save_branch, save_continuation, warning_on
from fivtui.orbits.following import End

ORBIT_COLUMNS = {
    "period": "s",
    "y_min": "m",
    "y_max": "m",
    "separations": "1",
    "separated_time": "s",
    "vx_max": "m/s",
    "force_max": "N",
}
REST = BranchPoint(0.3, ("up", "down"), Attractor(Kind.EQUILIBRIUM))
LOST = BranchPoint(0.7, ("up",), Attractor(Kind.UNSETTLED))
RESULT = Continuation(Parameters(), True, "mu", np.array([0.3, 0.7]), (REST, LOST))


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_what_has_no_orbit_has_no_numbers_of_one(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"c{suffix}"
    save_continuation(RESULT, path)
    columns, header = read_columns(path, "continuation"), read_header(path, "continuation")
    np.testing.assert_array_equal(columns["mu"], [0.3, 0.7])
    assert [header["kinds"][int(place)] for place in columns["kind"]] == [
        "equilibrium",
        "not settled",
    ]
    assert columns["up"].tolist() == [1, 1]
    assert columns["down"].tolist() == [1, 0]
    # At rest there is no orbit, but its amplitude is known.
    assert columns["half_range"][0] == 0.0
    assert math.isnan(columns["half_range"][1])
    for name in ORBIT_COLUMNS:
        assert np.isnan(columns[name]).all(), name


def test_every_column_has_its_unit_and_meaning(tmp_path: Path) -> None:
    save_continuation(RESULT, tmp_path / "c.parquet")
    fields = {
        field.name: (field.metadata[b"unit"].decode(), field.metadata[b"meaning"].decode())
        for field in pq.read_schema(tmp_path / "c.parquet")
    }
    spec = PARAMETERS["mu"]
    assert fields["mu"] == (spec.unit, spec.meaning)
    units = {name: unit for name, (unit, _) in fields.items() if name != "mu"}
    assert units == {"up": "1", "down": "1", "kind": "1", "half_range": "m", **ORBIT_COLUMNS}
    assert all(meaning for _, meaning in fields.values())
    assert fields["kind"][1] == "index in kinds"


def test_kinds_have_the_names_that_files_keep() -> None:
    assert [str(kind) for kind in KINDS] == [
        "equilibrium",
        "contact limit cycle",
        "separating limit cycle",
        "unbounded",
        "not settled",
    ]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_a_branch_in_a_file_has_its_cycles_and_its_events(tmp_path: Path, suffix: str) -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    path = tmp_path / f"b{suffix}"
    save_branch(result, path)
    columns, header = read_columns(path, "branch"), read_header(path, "branch")
    for name, values in result.to_columns().items():
        np.testing.assert_array_equal(columns[name], values)
    kinds = [header["event_kinds"][int(place)] for place in columns["event"] if place]
    assert kinds == ["touch", "fold"]
    assert header["events"] == ["hopf, subcritical", *kinds]
    assert header["event_periods"] == [event.period for event in result.events]
    assert header["parameters"] == {
        name: value for name, value in Parameters().as_dict().items() if name != "mu"
    }
    (fold,) = np.flatnonzero(columns["mu"] == header["event_values"][2])
    last = [result.points[fold].multipliers[-1].real, columns["multiplier_3_re"][fold]]
    assert last[0] == last[1]


def test_a_branch_is_drawn_full_where_it_is_stable_and_dashed_where_it_is_not() -> None:
    result = branch(None, "mu", low=0.25, high=0.6)
    (axes,) = branch_figure(result).axes
    lines = {str(line.get_label()): line for line in axes.lines}
    assert set(lines) == {"unstable", "stable", "hopf", "touch", "fold"}
    fold = result.events[-1].value
    drawn = 0
    for name, style in (("stable", "-"), ("unstable", "--")):
        line = lines[name]
        assert line.get_linestyle() == style
        cycles = {(p.value, p.half_range) for p in result.points if p.stable == (name == "stable")}
        seen = set(zip(*np.array(line.get_data()).tolist(), strict=True))
        assert {one for one in cycles if one[0] != fold} <= seen
        assert fold in {value for value, _ in seen}
        drawn += len(seen)
    assert drawn == len(result.points) + 1
    for event in result.events:
        x, y = np.array(lines[str(event.kind)].get_data())[:, 0].tolist()
        assert (x, y) == (event.value, 0.5 * (event.y_max - event.y_min))


def test_a_branch_that_grows_without_bounds_leaves_the_figure_and_not_the_rest() -> None:
    result = branch(None, "mu")
    assert max(point.half_range for point in result.points) > 1000.0
    stable = max(point.half_range for point in result.points if point.stable)
    (axes,) = branch_figure(result).axes
    assert axes.get_ylim() == pytest.approx((-0.1 * stable, 2.1 * stable))


def test_a_branch_that_was_cut_short_warns_of_it() -> None:
    whole = branch(None, "mu", low=0.25, high=0.6)
    assert warning_on(whole) is None
    cut = dataclasses.replace(whole, ends=(whole.ends[0], End.LOST))
    assert warning_on(cut) == "the branch cannot be followed farther at mu = 0.6"

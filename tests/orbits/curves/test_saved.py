"""Branches that begin at a cycle in a file."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fivtui import InputError, Parameters, attractors, branch
from fivtui.orbits.curves.result import CycleBranch
from fivtui.results.tables import save_result

WHOLE = branch(None, "mu", low=0.25, high=0.8)


def saved(folder: Path, suffix: str, result: CycleBranch = WHOLE) -> Path:
    path = folder / f"b{suffix}"
    if suffix == ".json":
        path.write_text(json.dumps(result.to_dict()), encoding="utf-8")
    else:
        save_result(result, path)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet", ".json"])
def test_from_a_cycle_in_a_file_the_same_branch_is_found_both_ways(
    tmp_path: Path, suffix: str
) -> None:
    found = branch(None, "mu", low=0.25, high=0.8, origin=saved(tmp_path, suffix))
    assert found.origin == "file"
    assert [event.kind for event in found.events] == [event.kind for event in WHOLE.events]
    for one, other in zip(found.events, WHOLE.events, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-10)
    assert found.ends == WHOLE.ends
    assert any(point.value == 0.7 for point in found.points)


def test_the_cycle_may_be_followed_along_another_parameter(tmp_path: Path) -> None:
    # Of the two cycles at μ = 0.35 the first in the file is the unstable one.
    p = Parameters(mu=0.35)
    found = branch(p, "F", low=70.0, high=90.0, origin=saved(tmp_path, ".csv"))
    start = next(point for point in found.points if point.value == 80.0)
    assert not start.stable
    assert {found.points[0].value, found.points[-1].value} <= {70.0, 90.0}


@pytest.mark.parametrize("many", [True, False])
def test_attractors_are_taken_as_json(tmp_path: Path, many: bool) -> None:
    found = attractors(Parameters(F=120.0))
    cycle = found.others[0].to_dict()
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"attractors": [cycle]} if many else cycle), encoding="utf-8")
    result = branch(Parameters(F=120.0), "mu", low=0.6, high=0.8, origin=path)
    start = next(point for point in result.points if point.value == 0.7)
    assert start.stable
    assert start.period == pytest.approx(cycle["period"], abs=1e-9)


@pytest.mark.parametrize(
    ("p", "separation", "said"),
    [
        (Parameters(F=120.0), True, "F = 120: must be 80, as in"),
        (Parameters(mu=0.9), True, "mu = 0.9: must be from 0.277877 to 0.8"),
        (Parameters(), False, "separation: must be considered, as in"),
    ],
)
def test_what_does_not_agree_with_the_file_is_said(
    tmp_path: Path, p: Parameters, separation: bool, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        branch(p, "mu", origin=saved(tmp_path, ".csv"), separation=separation)


@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", '{"attractors": []}', '{"period": 1}', "1"])
def test_json_without_a_cycle_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="must have limit cycles"):
        branch(None, "mu", origin=path)


def test_a_table_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="must be a branch of limit cycles"):
        branch(None, "mu", origin=path)


def test_a_branch_whose_points_are_all_at_one_value_serves_that_value(tmp_path: Path) -> None:
    one = WHOLE.points[-1]
    path = saved(tmp_path, ".csv", replace(WHOLE, points=(one, one)))
    found = branch(Parameters(mu=0.8), "mu", low=0.7, high=0.9, origin=path)
    assert any(point.value == 0.8 for point in found.points)

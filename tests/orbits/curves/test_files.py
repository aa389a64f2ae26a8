"""Branches that begin at a cycle in a file."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fivtui import InputError, Parameters, attractors, branch
from fivtui.orbits.curves.result import CycleBranch
from fivtui.results.tables import save_result

BRANCH = branch(None, "mu", low=0.25, high=0.8)


def save_branch(folder: Path, suffix: str, result: CycleBranch = BRANCH) -> Path:
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
    curve = branch(None, "mu", low=0.25, high=0.8, origin=save_branch(tmp_path, suffix))
    assert curve.origin == "file"
    assert [event.kind for event in curve.events] == [event.kind for event in BRANCH.events]
    for curve_event, expected_event in zip(curve.events, BRANCH.events, strict=True):
        assert curve_event.value == pytest.approx(expected_event.value, abs=1e-10)
    assert curve.ends == BRANCH.ends
    assert any(point.value == 0.7 for point in curve.points)


def test_the_cycle_may_be_followed_along_another_parameter(tmp_path: Path) -> None:
    # Of the two cycles at μ = 0.35 the first in the file is the unstable one.
    p = Parameters(mu=0.35)
    curve = branch(p, "F", low=70.0, high=90.0, origin=save_branch(tmp_path, ".csv"))
    start = next(point for point in curve.points if point.value == 80.0)
    assert not start.stable
    assert {curve.points[0].value, curve.points[-1].value} <= {70.0, 90.0}


@pytest.mark.parametrize("several", [True, False])
def test_a_branch_begins_at_an_attractor_in_json(tmp_path: Path, several: bool) -> None:
    # `others` are the attractors besides rest.
    (limit_cycle,) = attractors(Parameters(F=120.0)).others
    cycle = limit_cycle.to_dict()
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"attractors": [cycle]} if several else cycle), encoding="utf-8")
    result = branch(Parameters(F=120.0), "mu", low=0.6, high=0.8, origin=path)
    start = next(point for point in result.points if point.value == 0.7)
    assert start.stable
    assert start.period == pytest.approx(cycle["period"], abs=1e-9)


@pytest.mark.parametrize(
    ("p", "separation", "message"),
    [
        (Parameters(F=120.0), True, "F = 120: must be 80, as in"),
        (Parameters(mu=0.9), True, "mu = 0.9: must be from 0.277877 to 0.8"),
        (Parameters(), False, "separation: must be considered, as in"),
    ],
)
def test_parameters_that_contradict_the_file_are_refused(
    tmp_path: Path, p: Parameters, separation: bool, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        branch(p, "mu", origin=save_branch(tmp_path, ".csv"), separation=separation)


@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", '{"attractors": []}', '{"period": 1}', "1"])
def test_json_without_a_cycle_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="must have limit cycles"):
        branch(None, "mu", origin=path)


def test_a_table_without_cycles_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="must be a branch of limit cycles"):
        branch(None, "mu", origin=path)


def test_a_file_with_cycles_at_one_value_gives_the_cycle_at_that_value(tmp_path: Path) -> None:
    last_point = BRANCH.points[-1]
    path = save_branch(tmp_path, ".csv", replace(BRANCH, points=(last_point, last_point)))
    curve = branch(Parameters(mu=0.8), "mu", low=0.7, high=0.9, origin=path)
    assert any(point.value == 0.8 for point in curve.points)

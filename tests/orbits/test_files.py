"""A continuation in a file: what has no orbit has no numbers, and every column says what it is."""

import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from fivtui.io.tables import read_columns, read_header
from fivtui.model import System
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.orbits.branches import KINDS, BranchPoint, Continuation
from fivtui.orbits.explorer import Attractor, Kind
from fivtui.results.tables import save_result

ORBIT_COLUMNS = {
    "period": "s",
    "y_min": "m",
    "y_max": "m",
    "separations": "1",
    "separated_time": "s",
    "sticks": "1",
    "stick_time": "s",
    "vx_max": "m/s",
    "force_max": "N",
}
REST = BranchPoint(0.3, ("up", "down"), Attractor(Kind.EQUILIBRIUM))
LOST = BranchPoint(0.7, ("up",), Attractor(Kind.UNSETTLED))
RESULT = Continuation(System(Parameters()), "mu", np.array([0.3, 0.7]), (REST, LOST))


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
def test_what_has_no_orbit_has_no_numbers_of_one(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"c{suffix}"
    save_result(RESULT, path)
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
    save_result(RESULT, tmp_path / "c.parquet")
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
        "stick-slip limit cycle",
        "rest by stick",
    ]

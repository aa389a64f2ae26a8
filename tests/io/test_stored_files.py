"""Files of every kind and format that version 0.1 wrote are read."""

import json
from pathlib import Path

import numpy as np
import pytest

from fivtui.io.tables import FORMATS, read_columns, read_header
from fivtui.maps.files import load_map
from fivtui.model import InputError
from fivtui.studies import kind_of, load_study
from fivtui.sweeps.files import read_sweep
from fivtui.tradeoffs.files import load_tradeoff, tradeoff_to_dict
from fivtui.transient.files import load_trajectory, restore_transient

STORED = Path(__file__).parents[1] / "data" / "stored"


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_stored_trajectory_is_read(suffix: str) -> None:
    motion = load_trajectory(STORED / f"run{suffix}")
    assert motion.t.size == 31
    assert motion.t[-1] == 0.6
    assert read_header(STORED / f"run{suffix}", "trajectory")["parameters"]["mu"] == 0.5


@pytest.mark.parametrize("suffix", [*FORMATS, ".json"])
def test_a_stored_map_is_read(suffix: str) -> None:
    found = load_map(STORED / f"map{suffix}")
    assert found.names == ("mu", "F")
    assert found.value == "critical-mu"
    np.testing.assert_array_equal(found.axes[1], [-30.0, 15.0, 60.0])
    np.testing.assert_array_equal(found.values, load_map(STORED / "map.json").values)
    assert found.values[0, 2] == 0.31214412186165025


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_stored_sweep_is_read(suffix: str) -> None:
    found = read_sweep(STORED / f"sweep{suffix}")
    assert found.columns == [
        "F", "mu", "separation", "y_abs", "separations", "growth_rate", "stable", "status",
        "reason",
    ]  # fmt: skip
    assert len(found.rows) == found.study.members == 12
    assert found.rows[-1] == [
        80.0, 0.9, False, 0.6746107955555569, 0, 0.8361191124146161, False, "done", ""
    ]  # fmt: skip


@pytest.mark.parametrize("suffix", [".csv", ".json"])
def test_a_stored_trade_off_is_read(suffix: str) -> None:
    found = load_tradeoff(STORED / f"tradeoff{suffix}")
    assert tradeoff_to_dict(found) == json.loads((STORED / "tradeoff.json").read_text())


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize(
    ("kind", "columns", "key"),
    [
        ("modes", ["mu", "sigma_1", "omega_1"], "critical_mu"),
        ("branches", ["mu", "up", "down"], "kinds"),
        ("basin", ["x0", "y0", "attractor"], "attractors"),
        ("figure", ["k_nl", "mu"], "meanings"),
    ],
)
def test_a_stored_table_is_read(suffix: str, kind: str, columns: list[str], key: str) -> None:
    path, other = STORED / f"{kind}{suffix}", STORED / f"{kind}.csv"
    found = read_columns(path, kind)
    assert list(found)[: len(columns)] == columns
    for name, values in read_columns(other, kind).items():
        np.testing.assert_array_equal(found[name], values)
    assert read_header(path, kind)[key] == read_header(other, kind)[key]


def test_a_run_that_the_laboratory_kept_is_read() -> None:
    found = restore_transient(STORED / "kept-run.npz")
    assert found.method == "rk4"
    assert found.stats.cpu_s == 0.125
    assert found.trajectory is not None
    assert found.trajectory.t.size == 31
    assert found.final.t == 0.6


@pytest.mark.parametrize(
    ("stem", "kind"),
    [("run", "run"), ("map", "map"), ("sweep", "sweep"), ("tradeoff", "trade-off")],
)
def test_a_stored_file_is_told_by_what_it_says(stem: str, kind: str) -> None:
    paths = list(STORED.glob(f"{stem}.*"))
    assert paths
    for path in paths:
        assert kind_of(path) == kind
        assert type(load_study(kind, path)) is type(load_study(kind, paths[0]))


@pytest.mark.parametrize("stem", ["modes", "branches", "basin", "figure"])
def test_a_stored_file_that_is_not_read_is_refused(stem: str) -> None:
    for path in STORED.glob(f"{stem}.*"):
        with pytest.raises(
            InputError, match="not a run, uncertainty, sweep, trade-off, branch or map"
        ):
            kind_of(path)


def test_stored_outputs_and_events_of_an_fmu_are_read() -> None:
    table = read_columns(STORED / "fmu-run.csv", "table", ["time", "y", "n"])
    assert table["y"].tolist() == [0.1, 1.0 / 3.0, -2e-300]
    events = read_columns(STORED / "fmu-events.csv", "table", ["time", "name"], ["name"])
    assert events["name"].tolist() == ["n", "on", "on"]

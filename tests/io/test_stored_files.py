"""Stored files for which the registry of studies (`fivtui.studies`) has no reader.

Tables of version 0.1 keep their columns and headers. `tests/net` records what the registry reads.
"""

from pathlib import Path

import numpy as np
import pytest

from fivtui.io.tables import FORMATS, read_columns, read_header
from fivtui.transient.files import restore_transient

STORED = Path(__file__).parents[1] / "data" / "stored"


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize(
    # The headers name critical friction coefficients, the meaning of each number in a column
    # (`kinds`, `attractors`), and the meaning of each column (`meanings`).
    ("kind", "columns", "header_key"),
    [
        ("modes", ["mu", "sigma_1", "omega_1"], "critical_mu"),
        ("branches", ["mu", "up", "down"], "kinds"),
        ("basin", ["x0", "y0", "attractor"], "attractors"),
        ("figure", ["k_nl", "mu"], "meanings"),
    ],
)
def test_a_stored_table_is_read(
    suffix: str, kind: str, columns: list[str], header_key: str
) -> None:
    path, csv_path = STORED / f"{kind}{suffix}", STORED / f"{kind}.csv"
    actual = read_columns(path, kind)
    assert list(actual)[: len(columns)] == columns
    for name, values in read_columns(csv_path, kind).items():
        np.testing.assert_array_equal(actual[name], values)
    assert read_header(path, kind)[header_key] == read_header(csv_path, kind)[header_key]


# The laboratory is fivtui's terminal program, which stores runs between two starts.
def test_a_run_stored_by_the_laboratory_is_read() -> None:
    run = restore_transient(STORED / "kept-run.npz")
    assert (run.method, run.stats.cpu_s, run.final.t) == ("rk4", 0.125, 0.6)
    assert run.trajectory is not None
    assert run.trajectory.t.size == 31


def test_stored_outputs_and_events_of_an_fmu_are_read() -> None:
    table = read_columns(STORED / "fmu-run.csv", "table", selected=["time", "y", "n"])
    assert table["y"].tolist() == [0.1, 1.0 / 3.0, -2e-300]
    events = read_columns(
        STORED / "fmu-events.csv", "table", selected=["time", "name"], texts=["name"]
    )
    assert events["name"].tolist() == ["n", "on", "on"]

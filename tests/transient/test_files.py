"""Results in files and as plain data."""

import dataclasses
import io
import json
import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from fivtui.equilibrium.eigenvalues import stability
from fivtui.io import tables
from fivtui.io.tables import check_table_path
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.simulation import simulate
from fivtui.transient.files import (
    finite_trajectory,
    load_trajectory,
    save_trajectory,
    transient_to_dict,
)
from fivtui.transient.result import Transient
from fivtui.transient.trajectory import COLUMNS, Trajectory
from fivtui.version import __version__
from tests.io.test_files import file_size_limit

SUFFIXES = (".csv", ".npz", ".parquet")
COLUMN_NAMES = [column.name for column in COLUMNS]


@pytest.fixture(scope="module")
def transient() -> Transient:
    return simulate(Parameters(mu=0.75), t_end=6.0, samples=np.linspace(0.0, 6.0, 10_007))


def with_trajectory(transient: Transient, **columns: Any) -> Transient:
    trajectory = dataclasses.replace(finite_trajectory(transient), **columns)
    return dataclasses.replace(transient, trajectory=trajectory)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_saved_trajectory_loads_without_loss(
    transient: Transient, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"run{suffix}"
    save_trajectory(transient, path)
    loaded, original = load_trajectory(path), finite_trajectory(transient)
    for name in COLUMN_NAMES:
        values, expected = getattr(loaded, name), getattr(original, name)
        assert values.dtype == expected.dtype
        assert values.tobytes() == expected.tobytes()


def test_an_npz_contains_no_date(transient: Transient, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    save_trajectory(transient, path)
    with zipfile.ZipFile(path) as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def provenance_of_csv(path: Path) -> dict[str, Any]:
    lines = path.read_text(encoding="utf-8").splitlines()
    pairs = (line.removeprefix("# ").split(": ", 1) for line in lines if line.startswith("#"))
    return {key: json.loads(value) for key, value in pairs}


def provenance_of_npz(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files if name not in COLUMN_NAMES}
    return {
        key: dict(zip(array.dtype.names, array.item(), strict=True))
        if array.dtype.names
        else array.tolist()
        for key, array in arrays.items()
    }


def provenance_of_parquet(path: Path) -> dict[str, Any]:
    schema = pq.read_schema(path)
    data = {key.decode(): json.loads(value) for key, value in schema.metadata.items()}
    data["units"] = {field.name: field.metadata[b"unit"].decode() for field in schema}
    return data


@pytest.mark.parametrize(
    ("suffix", "provenance"),
    [
        (".csv", provenance_of_csv),
        (".npz", provenance_of_npz),
        (".parquet", provenance_of_parquet),
    ],
)
def test_a_file_records_its_request_and_units(
    transient: Transient,
    tmp_path: Path,
    suffix: str,
    provenance: Callable[[Path], dict[str, Any]],
) -> None:
    path = tmp_path / f"run{suffix}"
    save_trajectory(transient, path)
    assert provenance(path) == {
        "fivtui": __version__,
        "parameters": {
            **{name: spec.default for name, spec in PARAMETERS.items()},
            "mu": 0.75,
        },
        "separation": True,
        "start": list(transient.start),
        "t_end": 6.0,
        "method": "taylor",
        "tol": 1e-12,
        "units": {column.name: column.unit for column in COLUMNS},
    }


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_leaves_no_file(transient: Transient, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"run{suffix}"
    with file_size_limit(20_000), pytest.raises(InputError, match="cannot be written"):
        save_trajectory(transient, path)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_format_is_refused_with_the_known_ones(
    transient: Transient, tmp_path: Path
) -> None:
    path = tmp_path / "run.xlsx"
    for action in (
        lambda: save_trajectory(transient, path),
        lambda: check_table_path(path, "trajectory"),
        lambda: load_trajectory(path),
    ):
        with pytest.raises(InputError, match=r"run\.xlsx: .* \.csv, \.npz, \.parquet$"):
            action()


def test_without_pyarrow_a_parquet_file_is_refused_with_an_install_hint(
    transient: Transient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"run\.parquet: .*pyarrow: install fivtui\[parquet\]$"):
        save_trajectory(transient, tmp_path / "run.parquet")
    save_trajectory(transient, tmp_path / "run.csv")


def test_a_transient_without_samples_has_no_trajectory_to_save(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no trajectory"):
        save_trajectory(simulate(t_end=1.0), tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_sample_that_is_not_finite_is_never_written(transient: Transient, tmp_path: Path) -> None:
    force = finite_trajectory(transient).P.copy()
    force[5] = np.inf
    with pytest.raises(ComputationError, match=r"trajectory\.P is not a finite number; use"):
        save_trajectory(with_trajectory(transient, P=force), tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_csv_of_another_program_may_have_its_columns_in_any_order(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    text = '\ufeff"mode","t","x","vx","y","vy","P","note"\r\n1,0,1,2,-3,4,5e2,a\r\n\r\n'
    path.write_text(text, encoding="utf-8", newline="")
    loaded = load_trajectory(path)
    assert [getattr(loaded, name).tolist() for name in COLUMN_NAMES] == [
        [0.0], [1.0], [2.0], [-3.0], [4.0], [500.0], [1]
    ]  # fmt: skip


HEADER = "# a comment\nt,x,vx,y,vy,P,mode\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a trajectory: no column t, x, vx, y, vy, P, mode"),
        ("t,x,vx,y,vy\n0,0,0,0,0\n", "not a trajectory: no column P, mode"),
        (HEADER, "t: must have one number for each time, and at least one"),
        (HEADER + "0,0,0,0,0,0,1\n0,0,0\n", "not a trajectory: line 4: 3 values under 7 columns"),
        (HEADER + "0,0,0,zero,0,0,1\n", "not a trajectory: line 3: y = 'zero' is not a number"),
        (HEADER + "0,0,0,nan,0,0,1\n", "y: must be finite numbers"),
        (
            HEADER + "0,0,0,0,0,0,5\n",
            "mode: must be one of 0 (separated), 1 (contact), 2 (forward), 3 (backward), 4 (stick)",
        ),
        (HEADER + "1,0,0,0,0,0,1\n0,0,0,0,0,0,1\n", "t: must be ascending times"),
    ],
)
def test_a_wrong_csv_gives_one_line_with_file_and_position(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_trajectory(path)
    assert str(caught.value) == f"{path}: {message}"


def npz_bytes(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def npy_bytes(array: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


ZEROS = {name: np.zeros(3) for name in COLUMN_NAMES}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a trajectory: not an NPZ file"),
        (b"text", "not a trajectory: not an NPZ file"),
        (npy_bytes(np.zeros(3)), "not a trajectory: not an NPZ file"),
        (npz_bytes(**ZEROS)[:500], "not a trajectory: not an NPZ file, or damaged"),
        # Changed numbers, with which the checksums of the archive do not agree.
        (
            npz_bytes(**ZEROS).replace(b"\0" * 24, b"\1" * 24),
            "not a trajectory: not an NPZ file, or damaged",
        ),
        (npz_bytes(t=np.zeros(3)), "not a trajectory: no column x"),
        (
            npz_bytes(**(ZEROS | {"x": np.array([None] * 3)})),
            "not a trajectory: not an NPZ file, or damaged",
        ),
        (
            npz_bytes(**(ZEROS | {"x": np.array(["a"] * 3)})),
            "x: must have one number for each time",
        ),
        (npz_bytes(**(ZEROS | {"x": np.zeros(2)})), "x: must have one number for each time"),
    ],
)
def test_a_wrong_npz_gives_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_trajectory(path)
    assert str(caught.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_unreadable_files_give_one_line(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"run{suffix}"
    with pytest.raises(InputError, match="there is no such file"):
        load_trajectory(path)
    path.write_bytes(b"\xff" * 100)
    with pytest.raises(
        InputError, match=rf"run\{suffix}: not a trajectory: not an? (CSV|NPZ|Parquet) file"
    ):
        load_trajectory(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="is a folder, not a file"):
        load_trajectory(path)


def key_structure(data: object) -> object:
    # The keys of nested data, with ... for values.
    return (
        {key: key_structure(value) for key, value in data.items()}
        if isinstance(data, dict)
        else ...
    )


def test_a_transient_as_data_has_the_documented_keys(transient: Transient) -> None:
    data = transient_to_dict(transient)
    assert key_structure(data) == {
        "parameters": dict.fromkeys(PARAMETERS, ...),
        "separation": ...,
        "start": ...,
        "t_end": ...,
        "method": ...,
        "tol": ...,
        "step": ...,
        "final": dict.fromkeys(("t", "x", "vx", "y", "vy"), ...),
        "peak": dict.fromkeys(("y_abs", "y_max", "y_min", "x_abs", "vx_max"), ...),
        "steady": {"y_half_range": ...},
        "contact_force": {"min": ..., "max": ...},
        "events": {
            **dict.fromkeys(
                ("separations", "reattachments", "separated_time", "first", "last"), ...
            ),
            **dict.fromkeys(("sticks", "stick_time"), ...),
            "transitions": dict.fromkeys(("contact-separated", "separated-contact"), ...),
        },
        "stats": {"steps": ..., "cpu_s": ..., "kernel": ...},
        # Estimated numbers of correct digits of the final state.
        "final_digits": dict.fromkeys(("x", "vx", "y", "vy"), ...),
    }
    assert data["final"]["y"] == transient.final.y
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_a_transient_without_events_has_null_for_their_times() -> None:
    data = transient_to_dict(simulate(t_end=1.0))
    assert data["events"]["separations"] == 0
    assert data["events"]["first"] is data["events"]["last"] is None


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_never_becomes_data(transient: Transient, value: float) -> None:
    peak = transient.peak._replace(x_abs=value)
    with pytest.raises(ComputationError, match=r"peak\.x_abs is not a finite number; use"):
        transient_to_dict(dataclasses.replace(transient, peak=peak))
    result = stability(Parameters())
    values = result.eigenvalues.copy()
    values[1] = complex(0.0, value)
    with pytest.raises(ComputationError, match="eigenvalues is not a finite number"):
        dataclasses.replace(result, eigenvalues=values).to_dict()


def test_a_stability_analysis_as_data_has_the_documented_keys() -> None:
    result = stability(Parameters())
    data = result.to_dict()
    assert key_structure(data) == {
        "equilibrium": {"x": ..., "y": ..., "P": ...},
        "eigenvalues": ...,
        "growth_rate": ...,
        "stable": ...,
        "critical_mu": ...,
        # Speeds of the belt at which sliding gains or loses stability.
        "critical_speed": ...,
        "linear_critical_mu": ...,
        "modes": ...,
        # Distance to the loss of stability.
        "margin": {"mu": ..., "growth_rate": ...},
        "coalescence": {"frequency_distance": ..., "mu": ...},
    }
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert [complex(*pair) for pair in data["eigenvalues"]] == result.eigenvalues.tolist()
    assert data["critical_mu"] == [{"mu": result.critical_mu[0].mu, "becomes": "unstable"}]
    assert data["critical_mu"][0]["mu"] == pytest.approx(0.4394, abs=5e-5)


def test_a_system_without_coupling_has_no_critical_friction_coefficient() -> None:
    data = stability(Parameters(k3=0.0)).to_dict()
    assert data["critical_mu"] == []
    assert data["linear_critical_mu"] is None


def test_the_columns_of_a_file_are_those_of_a_trajectory() -> None:
    assert [field.name for field in dataclasses.fields(Trajectory)] == COLUMN_NAMES

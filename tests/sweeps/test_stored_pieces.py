"""Sweeps begun by earlier versions are continued, or refused with the reason."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import fivtui.sweeps.provenance as provenance_module
from fivtui.io import output_path
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.sweeps.arithmetic import arithmetic_digests
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.files import read_sweep
from fivtui.sweeps.run import WriteSummary, local_engine, sweep_to_file
from fivtui.sweeps.study import Study

STORED_FOLDER = Path(__file__).parents[1] / "data" / "stored"
STUDY = Study(
    Design({"F": Range(20.0, 120.0, 6), "mu": (0.2, 0.7)}),
    Parameters(),
    t_end=5.0,
    outputs=("y_abs", "separations", "growth_rate"),
)
# Members of the sweep, and those in the stored pieces.
MEMBERS, STORED_MEMBERS = 12, 6


def copy_stored(kernel: str, folder: Path) -> tuple[Path, dict[str, Any]]:
    """Copy the pieces of a partial sweep; return the path of its file, and its manifest."""
    parts = shutil.copytree(STORED_FOLDER / f"sweep-{kernel}.csv.parts", folder / "sweep.csv.parts")
    return folder / "sweep.csv", json.loads((parts / "manifest.json").read_text())


def continue_sweep(out: Path, **options: Any) -> WriteSummary:
    return sweep_to_file(STUDY, out, local_engine(1), **options)


def assert_refused(out: Path, message: str) -> None:
    """The sweep is refused, and its pieces do not change."""
    parts = out.with_name("sweep.csv.parts")

    def contents() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in parts.iterdir() if path.name != "lock"}

    before = contents()
    with pytest.raises(InputError, match=message):
        continue_sweep(out)
    assert contents() == before
    assert not out.exists()


@pytest.fixture
def expected_file(tmp_path: Path) -> bytes:
    out = tmp_path / "expected_file.csv"
    continue_sweep(out)
    return out.read_bytes()


def test_pieces_of_a_kernel_compiled_by_numba_are_refused_and_can_be_read(
    expected_file: bytes, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, manifest = copy_stored("numba", tmp_path)
    assert manifest["versions"]["numba"]
    assert_refused(out, r'begun with other versions, .* \(versions\.fivtui: "0\.1\.0" there')
    result = read_sweep(tmp_path / "sweep.csv.parts")
    assert len(result.rows) == STORED_MEMBERS
    # The reason is a difference in the last bits.
    column = result.columns.index("y_abs")
    peaks = [row[column] for row in result.rows]
    expected_rows = expected_file.decode().splitlines()[-MEMBERS:][:STORED_MEMBERS]
    expected_texts = [row.split(",")[column] for row in expected_rows]
    assert list(map(repr, peaks)) != expected_texts
    assert peaks == pytest.approx(list(map(float, expected_texts)), rel=1e-11)
    # With equal versions the arithmetic alone is a reason to refuse.
    monkeypatch.setattr(provenance_module, "versions", lambda _: manifest["versions"])
    assert_refused(out, r"last bits from the stored rows \(the kernel is compiled by numba there")
    monkeypatch.undo()
    assert continue_sweep(output_path(out, force=True)).stored_before == 0
    assert out.read_bytes() == expected_file


def test_pieces_of_the_kernel_in_c_are_continued_where_bits_are_the_same(
    expected_file: bytes, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, manifest = copy_stored("c", tmp_path)
    monkeypatch.setattr(provenance_module, "versions", lambda _: manifest["versions"])
    if arithmetic_digests(STUDY) == manifest["arithmetic"]:
        assert continue_sweep(out) == WriteSummary(MEMBERS, 0, STORED_MEMBERS)
        assert out.read_bytes().splitlines()[-MEMBERS:] == expected_file.splitlines()[-MEMBERS:]
    else:
        assert_refused(
            out, r"rows computed here would differ in their last bits from the stored rows \("
        )

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

STORED = Path(__file__).parents[1] / "data" / "stored"
STUDY = Study(
    Design({"F": Range(20.0, 120.0, 6), "mu": (0.2, 0.7)}),
    Parameters(),
    t_end=5.0,
    outputs=("y_abs", "separations", "growth_rate"),
)
MEMBERS, KEPT = 12, 6


def begun(kernel: str, folder: Path) -> tuple[Path, dict[str, Any]]:
    """A copy of a partial sweep, and its manifest."""
    parts = shutil.copytree(STORED / f"sweep-{kernel}.csv.parts", folder / "sweep.csv.parts")
    return folder / "sweep.csv", json.loads((parts / "manifest.json").read_text())


def go_on(out: Path, **options: Any) -> WriteSummary:
    return sweep_to_file(STUDY, out, local_engine(1), **options)


def refused(out: Path, message: str) -> None:
    parts = out.with_name("sweep.csv.parts")

    def stored() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in parts.iterdir() if path.name != "lock"}

    before = stored()
    with pytest.raises(InputError, match=message):
        go_on(out)
    assert stored() == before
    assert not out.exists()


@pytest.fixture
def right(tmp_path: Path) -> bytes:
    out = tmp_path / "right.csv"
    go_on(out)
    return out.read_bytes()


def test_pieces_of_a_kernel_compiled_by_numba_are_refused_and_can_be_read(
    right: bytes, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, manifest = begun("numba", tmp_path)
    refused(out, r'begun with other versions, .* \(versions\.numba: "0\.68\.1" there, none here\)')
    rows = read_sweep(tmp_path / "sweep.csv.parts").rows
    assert len(rows) == KEPT
    # The reason is a difference in the last bits.
    exact = [line.split(",")[3] for line in right.decode().splitlines()[-MEMBERS:]]
    assert [repr(row[3]) for row in rows] != exact[:KEPT]
    assert [row[3] for row in rows] == pytest.approx(list(map(float, exact[:KEPT])), rel=1e-11)
    monkeypatch.setattr(provenance_module, "versions", lambda _: manifest["versions"])
    refused(out, r"last bits from the stored rows \(the kernel is compiled by numba there")
    monkeypatch.undo()
    assert go_on(output_path(out, force=True)).stored_before == 0
    assert out.read_bytes() == right


def test_pieces_of_the_kernel_in_c_are_continued_where_bits_are_the_same(
    right: bytes, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, manifest = begun("c", tmp_path)
    monkeypatch.setattr(provenance_module, "versions", lambda _: manifest["versions"])
    if arithmetic_digests(STUDY) == manifest["arithmetic"]:
        assert go_on(out) == WriteSummary(MEMBERS, 0, KEPT)
        assert out.read_bytes().splitlines()[-MEMBERS:] == right.splitlines()[-MEMBERS:]
    else:
        refused(out, r"rows computed here would differ in their last bits from the stored rows \(")

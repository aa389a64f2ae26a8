"""A file never mixes rows of two sweeps: pieces, manifests, complete files and machines.

A sweep is stored in pieces until its file is complete; a manifest identifies their sweep. A piece's
file name is NUMBER.FAILED.DIGEST.CHECKSUM.csv: number of the piece in nine digits, number of failed
members, digest of the manifest, and checksum.

Trial members are computed only to identify a machine. The digests of their rows are its arithmetic:
they differ if the last bits of results do.
"""

import dataclasses
import errno
import json
import os
import shutil
from collections.abc import Callable, Generator, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fivtui.sweeps.arithmetic as arithmetic_module
import fivtui.sweeps.provenance as provenance_module
from fivtui.cli import run as command
from fivtui.io import output_path
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.sweeps.arithmetic import arithmetic_difference, arithmetic_digests
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.files import read_sweep, save_sweep
from fivtui.sweeps.formats import sweep_format
from fivtui.sweeps.pieces import SweepPiece
from fivtui.sweeps.rows import Rows, compute_rows
from fivtui.sweeps.run import WriteSummary, local_engine, sweep_to_file
from fivtui.sweeps.study import Study

STUDY = Study(
    Design({"F": Range(10.0, 120.0, 10), "mu": (0.1, 0.7)}),
    Parameters(),
    t_end=5.0,
    outputs=("y_abs", "separations", "stable"),
)
OTHER_STUDY = dataclasses.replace(STUDY, parameters=Parameters(m=6.0))
MEMBERS = 20
SUFFIXES = pytest.mark.parametrize("suffix", [".csv", ".parquet"])
OTHER_ARITHMETIC: dict[str, dict[str, Any]] = {
    "interpreted": {"kernel": "interpreted"},
    "last bits": {"transients": "0" * 32},
}


@pytest.fixture(autouse=True)
def _with_pyarrow() -> None:
    pytest.importorskip("pyarrow")


def run(out: Path, study: Study = STUDY, **options: Any) -> WriteSummary:
    return sweep_to_file(study, out, local_engine(1), **{"size": 3, **options})


def start_and_stop(out: Path, study: Study = STUDY, **options: Any) -> Path:
    """Compute a few pieces of a sweep; return their folder."""
    fractions: list[float] = []

    def progress(fraction: float) -> bool:
        fractions.append(fraction)
        return len(fractions) < 4

    with pytest.raises(Cancelled):
        run(out, study, progress=progress, **options)
    parts = out.with_name(f"{out.name}.parts")
    assert len(list(parts.glob("0*"))) >= 3
    return parts


def contents(folder: Path) -> dict[str, bytes]:
    """Contents of all files in a folder, by path."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def assert_refused(out: Path, message: str, study: Study = STUDY) -> None:
    """The sweep is refused with a message of one line, and no file changes."""
    before = contents(out.parent)
    with pytest.raises(InputError, match=message) as caught:
        run(out, study, size=None)
    assert "\n" not in str(caught.value)
    assert contents(out.parent) == before


@pytest.fixture(scope="module")
def expected_files(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], bytes]:
    """Contents of complete files of both sweeps, by suffix and sweep."""
    contents = {}
    for suffix in (".csv", ".parquet"):
        for name, study in (("study", STUDY), ("other study", OTHER_STUDY)):
            out = tmp_path_factory.mktemp("expected_files") / f"out{suffix}"
            run(out, study)
            contents[suffix, name] = out.read_bytes()
    return contents


def test_the_command_refuses_pieces_without_a_manifest(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    parts = start_and_stop(tmp_path / "out.csv")
    (parts / "manifest.json").unlink()
    before = contents(tmp_path)
    args = ["sweep", "--vary=F=10:120:10", "--vary=mu=0.1,0.7", "--t-end=5", "--set=m=6",
            "--output=y_abs", "--output=separations", "--output=stable", "--piece=3",
            "--out=out.csv"]  # fmt: skip
    assert command(args) == 2
    message = capsys.readouterr().err
    assert message.startswith("fivtui: out.csv.parts: has pieces but no manifest.json")
    assert message.count("\n") == 1
    assert contents(tmp_path) == before
    assert command([*args, "--force"]) == 0
    written = read_sweep(tmp_path / "out.csv")
    assert written.study.parameters.m == 6.0
    exact = compute_rows(OTHER_STUDY, 0, MEMBERS)
    assert written.table.numbers["y_abs"].tolist() == exact.numbers["y_abs"].tolist()
    assert not parts.exists()


@SUFFIXES
def test_pieces_under_the_manifest_of_another_sweep_are_refused(
    suffix: str, expected_files: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    parts = start_and_stop(out)
    (tmp_path / "other").mkdir()
    manifest = start_and_stop(tmp_path / "other" / out.name, OTHER_STUDY) / "manifest.json"
    shutil.copy(manifest, parts)
    assert_refused(out, "has pieces that do not belong to its manifest.json", OTHER_STUDY)
    assert run(output_path(out, force=True), OTHER_STUDY).stored_before == 0
    assert out.read_bytes() == expected_files[suffix, "other study"]


@SUFFIXES
def test_a_piece_under_the_name_of_another_one_is_computed_again(
    suffix: str, expected_files: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    first, second, *remaining = sorted(start_and_stop(out).glob(f"0*{suffix}"))
    first_number, first_failed, *first_rest = first.name.split(".")
    second_number, *_ = second.name.split(".")
    second.rename(second.with_name(".".join((second_number, first_failed, *first_rest))))
    first.rename(first.with_name(".".join((first_number, "1", *first_rest))))
    assert run(out).stored_before == 3 * len(remaining)
    assert out.read_bytes() == expected_files[suffix, "study"]


def keep_first_half(content: bytes) -> bytes:
    return content[: len(content) // 2]


def cut_last_byte(content: bytes) -> bytes:
    return content[:-1]


def cut_out_middle(content: bytes) -> bytes:
    # The damage is a full row in CSV, as many bytes of a column in Parquet.
    start = content.rindex(b"\n", 0, -20) if content.startswith(b"#") else 100
    stop = content.index(b"\n", start + 1) if content.startswith(b"#") else 120
    return content[:start] + content[stop:]


def repeat_last_line(content: bytes) -> bytes:
    return content + content.splitlines(keepends=True)[-1]


def keep_header(content: bytes) -> bytes:
    lines = content.splitlines(keepends=True)
    return b"".join(line for line in lines if line.startswith((b"#", b"F,")))


DAMAGE_OF_BOTH_FORMATS = (keep_first_half, cut_last_byte, cut_out_middle)
DAMAGE = [
    *((damage, suffix) for damage in DAMAGE_OF_BOTH_FORMATS for suffix in (".csv", ".parquet")),
    (repeat_last_line, ".csv"),
    (keep_header, ".csv"),
]


@pytest.mark.parametrize(("damage", "suffix"), DAMAGE)
def test_a_damaged_file_is_never_called_complete(
    damage: Callable[[bytes], bytes],
    suffix: str,
    expected_files: dict[tuple[str, str], bytes],
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    complete = expected_files[suffix, "study"]
    out.write_bytes(damage(complete))
    assert out.read_bytes() != complete
    assert_refused(out, r"exists already, and is .*damaged.*forc")
    assert run(output_path(out, force=True)) == WriteSummary(
        members=MEMBERS, failed=0, stored_before=0
    )
    assert out.read_bytes() == complete
    # Nothing is computed: no failed members are counted.
    assert run(out) == WriteSummary(members=MEMBERS, failed=None, stored_before=MEMBERS)


def pretend_arithmetic(monkeypatch: pytest.MonkeyPatch, changed: dict[str, Any]) -> None:
    """Replace digests by those that another machine would have."""

    def other_digests(study: Study) -> dict[str, Any]:
        return arithmetic_digests(study) | changed

    monkeypatch.setattr(provenance_module, "arithmetic_digests", other_digests)


@SUFFIXES
@pytest.mark.parametrize("reason", OTHER_ARITHMETIC)
def test_rows_of_two_machines_are_not_mixed(
    reason: str,
    suffix: str,
    expected_files: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    start_and_stop(out)
    pretend_arithmetic(monkeypatch, OTHER_ARITHMETIC[reason])
    assert_refused(out, rf"would differ in their last bits .* \(.*{reason}.*continue where")
    monkeypatch.undo()
    assert run(out).stored_before >= 9
    assert out.read_bytes() == expected_files[suffix, "study"]


@SUFFIXES
def test_a_finished_file_says_its_arithmetic_and_is_complete_anywhere(
    suffix: str,
    expected_files: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    out.write_bytes(expected_files[suffix, "study"])
    provenance = sweep_format(out).provenance(out)
    assert provenance is not None
    assert provenance["arithmetic"] == arithmetic_digests(STUDY)
    pretend_arithmetic(monkeypatch, OTHER_ARITHMETIC["interpreted"])
    assert run(out).failed is None
    assert out.read_bytes() == expected_files[suffix, "study"]


def test_a_file_of_an_older_version_is_complete_and_its_pieces_are_refused(
    expected_files: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    lines = expected_files[".csv", "study"].splitlines(keepends=True)
    old = [line for line in lines if not line.startswith(b"# arithmetic")]
    assert len(old) == len(lines) - 1
    out.write_bytes(b"".join(old))
    assert run(out).failed is None
    out.unlink()
    parts = start_and_stop(out)
    manifest = json.loads((parts / "manifest.json").read_text())
    del manifest["arithmetic"]
    (parts / "manifest.json").write_text(json.dumps(manifest))
    for path in parts.glob("0*.csv"):
        number, failed, _digest, checksum, suffix = path.name.split(".")
        path.rename(parts / f"{number}.{failed}.{checksum}.{suffix}")
    assert_refused(out, "an older fivtui began the sweep and did not record the arithmetic")
    with pytest.raises(InputError, match="an older fivtui began this sweep"):
        read_sweep(parts)
    (parts / "manifest.json").unlink()
    assert_refused(out, r"has pieces but no manifest\.json")
    assert run(output_path(out, force=True)).stored_before == 0
    assert out.read_bytes() == expected_files[".csv", "study"]


def test_a_complete_file_leaves_the_pieces_of_another_sweep(
    expected_files: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    run(out)
    parts = start_and_stop(output_path(out, force=True), OTHER_STUDY)
    before = contents(parts)
    before.pop("lock")
    assert run(out).failed is None
    assert contents(parts) == before
    assert run(output_path(out, force=True), OTHER_STUDY).stored_before >= 9
    assert out.read_bytes() == expected_files[".csv", "other study"]


@SUFFIXES
def test_rows_from_a_file_keep_its_provenance(
    suffix: str,
    expected_files: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    pretend_arithmetic(monkeypatch, OTHER_ARITHMETIC["last bits"])
    moved_file = tmp_path / "there.csv"
    run(moved_file)
    monkeypatch.undo()
    rewritten = tmp_path / f"rewritten{suffix}"
    save_sweep(read_sweep(moved_file), rewritten)
    provenance = sweep_format(rewritten).provenance(rewritten)
    assert provenance is not None
    assert provenance["arithmetic"]["transients"] == "0" * 32
    assert run(rewritten).failed is None
    local_file = tmp_path / "here.csv"
    local_file.write_bytes(expected_files[".csv", "study"])
    save_sweep(read_sweep(local_file), tmp_path / f"here-rewritten{suffix}")
    assert (tmp_path / f"here-rewritten{suffix}").read_bytes() == expected_files[suffix, "study"]


def test_unreadable_files_are_reported(
    expected_files: dict[tuple[str, str], bytes], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, read = tmp_path / "out.csv", Path.open

    def broken(path: Path, mode: str = "r", **options: Any) -> Any:
        if path == out:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return read(path, mode, **options)

    out.write_bytes(expected_files[".csv", "study"])
    monkeypatch.setattr(Path, "open", broken)
    with pytest.raises(InputError, match=r"out\.csv: cannot be read: Input/output error"):
        run(out)
    monkeypatch.undo()
    out.unlink()
    manifest = start_and_stop(out) / "manifest.json"
    manifest.unlink()
    manifest.mkdir()
    assert_refused(out, r"out\.csv\.parts: cannot be read: Is a directory")


def test_a_piece_that_lacks_rows_is_not_stored(tmp_path: Path) -> None:
    def engine(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        for piece in pieces:
            # Piece 0 is complete, piece 1 lacks its last row.
            yield piece, compute_rows(study, piece.first, piece.stop - piece.number)

    out = tmp_path / "out.csv"
    with pytest.raises(ComputationError, match=r"2 rows .* for 3 members.* 3 of 20 memb"):
        sweep_to_file(STUDY, out, engine, size=3)
    assert not out.exists()
    assert run(out).stored_before == 3


def test_one_last_bit_of_one_trial_member_tells_machines_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    local_digest = arithmetic_digests(STUDY)
    arithmetic_module._row_digest.cache_clear()
    assert arithmetic_digests(STUDY) == local_digest
    arithmetic_module._row_digest.cache_clear()

    def other(study: Study, first: int, end: int) -> Rows:
        rows = compute_rows(study, first, end)
        name = "y_abs" if "y_abs" in rows.numbers else "growth_rate"
        rows.numbers[name][-1] = np.nextafter(rows.numbers[name][-1], np.inf)
        return rows

    monkeypatch.setattr(arithmetic_module, "compute_rows", other)
    changed_digest = arithmetic_digests(STUDY)
    arithmetic_module._row_digest.cache_clear()
    assert changed_digest["transients"] != local_digest["transients"]
    assert changed_digest["stability"] != local_digest["stability"]
    assert "last bits" in arithmetic_difference(changed_digest, local_digest)
    assert arithmetic_difference(local_digest, local_digest) == ""


def test_arithmetic_covers_computed_outputs_only(monkeypatch: pytest.MonkeyPatch) -> None:
    static = dataclasses.replace(STUDY, outputs=("stable",))
    assert set(arithmetic_digests(static)) == {"stability"}
    moving = dataclasses.replace(STUDY, outputs=("x_end",))
    assert set(arithmetic_digests(moving)) == {"transients", "kernel"}
    verified = dataclasses.replace(static, accuracy=(("peak", 1e-4),))
    assert set(arithmetic_digests(verified)) == {"stability", "transients", "kernel"}


def test_the_manifest_keeps_the_names_that_older_sweeps_are_resumed_by(tmp_path: Path) -> None:
    manifest = json.loads((start_and_stop(tmp_path / "out.csv") / "manifest.json").read_text())
    assert {"piece_members", "columns", "arithmetic"} <= set(manifest)

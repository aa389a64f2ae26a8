"""A file never mixes rows of two sweeps: pieces, manifests, finished files and machines."""

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
HEAVIER = dataclasses.replace(STUDY, parameters=Parameters(m=6.0))
MEMBERS = 20
SUFFIXES = pytest.mark.parametrize("suffix", [".csv", ".parquet"])
OTHER: dict[str, dict[str, Any]] = {
    "interpreted": {"kernel": "interpreted"},
    "last bits": {"transients": "0" * 32},
}


@pytest.fixture(autouse=True)
def _with_pyarrow() -> None:
    pytest.importorskip("pyarrow")


def run(out: Path, study: Study = STUDY, **options: Any) -> WriteSummary:
    return sweep_to_file(study, out, local_engine(1), **{"size": 3, **options})


def begun(out: Path, study: Study = STUDY, **options: Any) -> Path:
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
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def refused(out: Path, message: str, study: Study = STUDY) -> None:
    before = contents(out.parent)
    with pytest.raises(InputError, match=message) as caught:
        run(out, study, size=None)
    assert "\n" not in str(caught.value)
    after = contents(out.parent)
    assert after == before


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], bytes]:
    contents = {}
    for suffix in (".csv", ".parquet"):
        for name, study in (("lighter", STUDY), ("heavier", HEAVIER)):
            out = tmp_path_factory.mktemp("right") / f"out{suffix}"
            run(out, study)
            contents[suffix, name] = out.read_bytes()
    return contents


def test_the_command_refuses_pieces_without_a_manifest(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    parts = begun(tmp_path / "out.csv")
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
    exact = compute_rows(HEAVIER, 0, MEMBERS)
    assert written.table.numbers["y_abs"].tolist() == exact.numbers["y_abs"].tolist()
    assert not parts.exists()


@SUFFIXES
def test_pieces_under_the_manifest_of_another_sweep_are_refused(
    suffix: str, right: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    parts = begun(out)
    (tmp_path / "other").mkdir()
    manifest = begun(tmp_path / "other" / out.name, HEAVIER) / "manifest.json"
    shutil.copy(manifest, parts)
    refused(out, "has pieces that do not belong to its manifest.json", HEAVIER)
    assert run(output_path(out, force=True), HEAVIER).stored_before == 0
    assert out.read_bytes() == right[suffix, "heavier"]


@SUFFIXES
def test_a_piece_under_the_name_of_another_one_is_computed_again(
    suffix: str, right: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    first, second, *remaining = sorted(begun(out).glob(f"0*{suffix}"))
    second.rename(second.with_name(second.name[:9] + first.name[9:]))
    first.rename(first.with_name(first.name[:9] + ".1" + first.name[11:]))
    assert run(out).stored_before == 3 * len(remaining)
    assert out.read_bytes() == right[suffix, "lighter"]


def halve(content: bytes) -> bytes:
    return content[: len(content) // 2]


def cut_the_end(content: bytes) -> bytes:
    return content[:-1]


def cut_a_piece_out(content: bytes) -> bytes:
    # The damage is a full row in CSV, as many bytes of a column in Parquet.
    start = content.rindex(b"\n", 0, -20) if content.startswith(b"#") else 100
    stop = content.index(b"\n", start + 1) if content.startswith(b"#") else 120
    return content[:start] + content[stop:]


def double_the_end(content: bytes) -> bytes:
    return content + content.splitlines(keepends=True)[-1]


def cut_after_the_names(content: bytes) -> bytes:
    lines = content.splitlines(keepends=True)
    return b"".join(line for line in lines if line.startswith((b"#", b"F,")))


BOTH = (halve, cut_the_end, cut_a_piece_out)
DAMAGE = [
    *((damage, suffix) for damage in BOTH for suffix in (".csv", ".parquet")),
    (double_the_end, ".csv"),
    (cut_after_the_names, ".csv"),
]


@pytest.mark.parametrize(("damage", "suffix"), DAMAGE)
def test_a_damaged_file_is_never_called_complete(
    damage: Callable[[bytes], bytes],
    suffix: str,
    right: dict[tuple[str, str], bytes],
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    complete = right[suffix, "lighter"]
    out.write_bytes(damage(complete))
    assert out.read_bytes() != complete
    refused(out, r"exists already, and is .*damaged.*forc")
    assert run(output_path(out, force=True)) == WriteSummary(MEMBERS, 0, 0)
    assert out.read_bytes() == complete
    assert run(out) == WriteSummary(MEMBERS, None, MEMBERS)


def elsewhere(monkeypatch: pytest.MonkeyPatch, changed: dict[str, Any]) -> None:
    # The digest that another machine would have.
    def other(study: Study) -> dict[str, Any]:
        return arithmetic_digests(study) | changed

    monkeypatch.setattr(provenance_module, "arithmetic_digests", other)


@SUFFIXES
@pytest.mark.parametrize("reason", OTHER)
def test_rows_of_two_machines_are_not_mixed(
    reason: str,
    suffix: str,
    right: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    begun(out)
    elsewhere(monkeypatch, OTHER[reason])
    refused(out, rf"would differ in their last bits .* \(.*{reason}.*continue where")
    monkeypatch.undo()
    assert run(out).stored_before >= 9
    assert out.read_bytes() == right[suffix, "lighter"]


@SUFFIXES
def test_a_finished_file_says_its_arithmetic_and_is_complete_anywhere(
    suffix: str,
    right: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    out = tmp_path / f"out{suffix}"
    out.write_bytes(right[suffix, "lighter"])
    provenance = sweep_format(out).provenance(out)
    assert provenance is not None
    assert provenance["arithmetic"] == arithmetic_digests(STUDY)
    elsewhere(monkeypatch, OTHER["interpreted"])
    assert run(out).failed is None
    assert out.read_bytes() == right[suffix, "lighter"]


def test_a_file_of_an_older_version_is_complete_and_its_pieces_are_refused(
    right: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    lines = right[".csv", "lighter"].splitlines(keepends=True)
    old = [line for line in lines if not line.startswith(b"# arithmetic")]
    assert len(old) == len(lines) - 1
    out.write_bytes(b"".join(old))
    assert run(out).failed is None
    out.unlink()
    parts = begun(out)
    manifest = json.loads((parts / "manifest.json").read_text())
    del manifest["arithmetic"]
    (parts / "manifest.json").write_text(json.dumps(manifest))
    for path in parts.glob("0*.csv"):
        number, failed, _, checksum, suffix = path.name.split(".")
        path.rename(parts / f"{number}.{failed}.{checksum}.{suffix}")
    refused(out, "an older fivtui began the sweep and did not record the arithmetic")
    with pytest.raises(InputError, match="an older fivtui began this sweep"):
        read_sweep(parts)
    (parts / "manifest.json").unlink()
    refused(out, r"has pieces but no manifest\.json")
    assert run(output_path(out, force=True)).stored_before == 0
    assert out.read_bytes() == right[".csv", "lighter"]


def test_a_complete_file_leaves_the_pieces_of_another_sweep(
    right: dict[tuple[str, str], bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    run(out)
    parts = begun(output_path(out, force=True), HEAVIER)
    before = contents(parts)
    before.pop("lock")
    assert run(out).failed is None
    assert contents(parts) == before
    assert run(output_path(out, force=True), HEAVIER).stored_before >= 9
    assert out.read_bytes() == right[".csv", "heavier"]


@SUFFIXES
def test_rows_from_a_file_keep_its_provenance(
    suffix: str,
    right: dict[tuple[str, str], bytes],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    elsewhere(monkeypatch, OTHER["last bits"])
    moved_file = tmp_path / "there.csv"
    run(moved_file)
    monkeypatch.undo()
    again = tmp_path / f"again{suffix}"
    save_sweep(read_sweep(moved_file), again)
    provenance = sweep_format(again).provenance(again)
    assert provenance is not None
    assert provenance["arithmetic"]["transients"] == "0" * 32
    assert run(again).failed is None
    local_file = tmp_path / "here.csv"
    local_file.write_bytes(right[".csv", "lighter"])
    save_sweep(read_sweep(local_file), tmp_path / f"here-again{suffix}")
    assert (tmp_path / f"here-again{suffix}").read_bytes() == right[suffix, "lighter"]


def test_unreadable_files_are_reported(
    right: dict[tuple[str, str], bytes], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out, read = tmp_path / "out.csv", Path.open

    def broken(path: Path, mode: str = "r", **options: Any) -> Any:
        if path == out:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return read(path, mode, **options)

    out.write_bytes(right[".csv", "lighter"])
    monkeypatch.setattr(Path, "open", broken)
    with pytest.raises(InputError, match=r"out\.csv: cannot be read: Input/output error"):
        run(out)
    monkeypatch.undo()
    out.unlink()
    manifest = begun(out) / "manifest.json"
    manifest.unlink()
    manifest.mkdir()
    refused(out, r"out\.csv\.parts: cannot be read: Is a directory")


def test_a_piece_that_lacks_rows_is_not_stored(tmp_path: Path) -> None:
    def engine(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        for piece in pieces:
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
    manifest = json.loads((begun(tmp_path / "out.csv") / "manifest.json").read_text())
    assert {"piece_members", "columns", "arithmetic"} <= set(manifest)

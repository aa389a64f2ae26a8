"""Sweeps in files resume after any interruption and give the same file.

Until the file is complete, its rows are in pieces in the folder ``FILE.parts``. A piece's file name
is NUMBER.FAILED.DIGEST.CHECKSUM.csv: number of the piece in nine digits, number of failed members,
digest of the manifest, and checksum.
"""

import dataclasses
import errno
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fivtui.sweeps.provenance as provenance_module
import fivtui.sweeps.store as store_module
from fivtui import Parameters
from fivtui.io import hold_lock, output_path, save_bytes
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.run import WriteSummary, load_sweep, local_engine, sweep_in_memory, sweep_to_file
from fivtui.sweeps.store import default_piece_size
from fivtui.sweeps.study import Study
from tests.io.test_files import file_size_limit, names
from tests.support.processes import run_python

ROOT = Path(__file__).parents[2]
# Some members grow without bound and fail; the reasons in their rows have commas, as CSV does.
STUDY = Study(
    Design({"F": Range(10.0, 120.0, 5), "mu": (0.1, 2.0)}),
    Parameters(k2=186.0, k_nl=0.0),
    cases=(True, False),
    t_end=1000.0,
    outputs=("y_abs", "separations", "stable"),
)
# Members per piece.
SIZE = 3
SUFFIXES = pytest.mark.parametrize("suffix", [".csv", ".parquet"])


@pytest.fixture(autouse=True)
def _with_pyarrow() -> None:
    pytest.importorskip("pyarrow")


def run(out: Path, study: Study = STUDY, **options: Any) -> WriteSummary:
    return sweep_to_file(study, out, local_engine(2), **{"size": SIZE, **options})


def stop_after(count: int) -> Callable[[float], bool]:
    """A progress callback that cancels at a call after `count` calls."""
    calls = iter(range(count + 1))
    return lambda _fraction: next(calls) < count


def interrupt(out: Path, study: Study = STUDY, pieces: int = 4) -> Path:
    """Cancel a sweep after some pieces; return their folder."""
    with pytest.raises(Cancelled, match="the same command continues"):
        run(out, study, progress=stop_after(pieces))
    assert not out.exists()
    return out.with_name(f"{out.name}.parts")


def test_a_piece_stored_just_before_ctrl_c_is_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def save_and_stop(content: bytes, path: Path, **options: Any) -> None:
        save_bytes(content, path, **options)
        if path.suffix == ".csv":
            raise KeyboardInterrupt

    monkeypatch.setattr(store_module, "save_bytes", save_and_stop)
    with pytest.raises(Cancelled, match=f"{SIZE} of 20 members are kept"):
        run(tmp_path / "out.csv")
    assert len(list((tmp_path / "out.csv.parts").glob("0*.csv"))) == 1


@pytest.fixture(scope="module")
def expected_files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    contents = {}
    for suffix in (".csv", ".parquet"):
        out = tmp_path_factory.mktemp("expected_files") / f"out{suffix}"
        assert run(out) == WriteSummary(members=20, failed=5, stored_before=0)
        assert names(out.parent) == [out.name]
        contents[suffix] = out.read_bytes()
    return contents


@SUFFIXES
def test_files_read_back_equal_the_computed_rows(
    suffix: str, expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    out.write_bytes(expected_files[suffix])
    assert load_sweep(STUDY, out).rows == sweep_in_memory(STUDY, local_engine(1)).rows


def test_a_file_says_units_design_and_versions(
    expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    import pyarrow.parquet as pq

    lines = expected_files[".csv"].decode().splitlines()
    comments = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    out = tmp_path / "out.parquet"
    out.write_bytes(expected_files[".parquet"])
    schema = pq.read_schema(out)
    for header in (comments, {key.decode(): value for key, value in schema.metadata.items()}):
        sweep = json.loads(header["sweep"])
        assert sweep["design"]["axes"][1] == ["mu", [0.1, 2.0]]
        assert sweep["parameters"]["k2"] == 186.0
        assert json.loads(header["versions"])["numpy"] == np.__version__
    assert json.loads(comments["units"])["y_abs"] == "m"
    assert schema.field("y_abs").metadata[b"unit"] == b"m"
    assert [str(field.type) for field in schema] == [
        "double", "double", "bool", "double", "int64", "bool", "string", "string",
    ]  # fmt: skip


@SUFFIXES
def test_a_stopped_sweep_continues_with_the_missing_pieces(
    suffix: str, expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    # Progress is reported before the first piece and after each one. Pieces that are running at a
    # stop may be stored or not, so only those before the first stop are certain.
    interrupt(out, pieces=3)
    interrupt(out, pieces=2)
    summary = run(out, size=None)
    assert 3 * SIZE <= summary.stored_before < 20
    assert out.read_bytes() == expected_files[suffix]
    assert names(tmp_path) == [out.name]
    assert run(out) == WriteSummary(members=20, failed=None, stored_before=20)


@SUFFIXES
@pytest.mark.parametrize("stride", [3, pytest.param(1, marks=pytest.mark.whole)])
def test_a_kill_at_any_file_operation_loses_nothing(
    suffix: str, stride: int, tmp_path: Path
) -> None:
    printed = run_python("-m", "tests.support.sweep_kill", tmp_path, suffix, stride)
    assert all(int(count) > 10 for count in printed.split())


def flip_first_bit(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(bytes([content[0] ^ 1]) + content[1:])


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1])


def make_empty(path: Path) -> None:
    path.write_bytes(b"")


@SUFFIXES
@pytest.mark.parametrize("damage", [flip_first_bit, truncate, make_empty, Path.unlink])
def test_a_damaged_piece_is_computed_again(
    damage: Callable[[Path], None], suffix: str, expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    parts = interrupt(out)
    pieces = sorted(parts.glob(f"0*{suffix}"))
    damage(pieces[1])
    summary = run(out)
    assert summary.stored_before == SIZE * (len(pieces) - 1)
    assert out.read_bytes() == expected_files[suffix]


def test_partial_files_of_a_killed_process_are_removed(
    expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    parts = interrupt(out)
    (piece, *_) = parts.glob("0*.csv")
    (parts / ".fivtui-0123.tmp").write_bytes(b"half")
    (parts / "merged.csv").write_bytes(b"half")
    # A duplicate piece with another number of failed members, and a piece out of range.
    (parts / piece.name.replace(".0.", ".1.")).write_bytes(piece.read_bytes())
    _, failed_and_digests = piece.name.split(".", 1)
    (parts / f"999999999.{failed_and_digests}").write_bytes(piece.read_bytes())
    run(out)
    assert out.read_bytes() == expected_files[".csv"]
    assert names(tmp_path) == ["out.csv"]


def test_files_of_other_programs_are_not_removed(
    expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out, mine = tmp_path / "out.csv", tmp_path / "out.csv.parts" / "notes.txt"
    mine.parent.mkdir()
    mine.write_text("mine")
    run(out)
    assert out.read_bytes() == expected_files[".csv"]
    assert names(mine.parent) == ["notes.txt"]
    assert run(out).failed is None


OTHER_STUDIES: dict[str, tuple[Study, str]] = {
    "parameters": (
        dataclasses.replace(STUDY, parameters=Parameters(k2=187.0, k_nl=0.0)),
        r"parameters.k2: 186.0 there, 187.0 here",
    ),
    "design": (
        dataclasses.replace(STUDY, design=Design({"F": Range(10.0, 121.0, 5), "mu": (0.1, 2.0)})),
        "design.axes",
    ),
    "order": (
        dataclasses.replace(STUDY, design=Design({"mu": (0.1, 2.0), "F": Range(10.0, 120.0, 5)})),
        "design.axes",
    ),
    "cases": (dataclasses.replace(STUDY, cases=(False, True)), "separation"),
    "t_end": (dataclasses.replace(STUDY, t_end=999.0), "t_end: 1000.0 there, 999.0 here"),
    "tol": (dataclasses.replace(STUDY, tol=1e-9), "tol"),
    "start": (dataclasses.replace(STUDY, start=(0.0, 0.0, 0.0, 0.0)), "start"),
    "outputs": (dataclasses.replace(STUDY, outputs=("y_abs",)), "outputs"),
}


@pytest.mark.parametrize("change", OTHER_STUDIES)
def test_another_sweep_is_refused_not_mixed(change: str, tmp_path: Path) -> None:
    study, message = OTHER_STUDIES[change]
    out = tmp_path / "out.csv"
    parts = interrupt(out)
    before = {path.name: path.read_bytes() for path in parts.iterdir()}
    with pytest.raises(InputError, match=message):
        run(out, study)
    assert {path.name: path.read_bytes() for path in parts.iterdir()} == before
    assert not out.exists()


def test_other_versions_and_sizes_are_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    parts = interrupt(out)
    with pytest.raises(InputError, match="members of a piece: 3 there, 4 here"):
        run(out, size=4)
    monkeypatch.setattr(provenance_module, "__version__", "9.9")
    with pytest.raises(InputError, match=r'versions.fivtui: "\S+" there, "9.9" here'):
        run(out)
    monkeypatch.undo()
    (parts / "manifest.json").write_text("{")
    with pytest.raises(InputError, match=r"manifest.json is damaged"):
        run(out)


def test_force_starts_another_sweep_but_continues_the_same(
    expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    interrupt(out, OTHER_STUDIES["t_end"][0])
    assert run(output_path(out, force=True)).stored_before == 0
    assert out.read_bytes() == expected_files[".csv"]
    with pytest.raises(Cancelled):
        run(output_path(out, force=True), progress=stop_after(3))
    assert out.read_bytes() == expected_files[".csv"]
    assert run(output_path(out, force=True)).stored_before > 0
    with pytest.raises(InputError, match="exists already"):
        run(out, OTHER_STUDIES["t_end"][0])
    assert out.read_bytes() == expected_files[".csv"]


@SUFFIXES
def test_a_full_disk_stops_with_a_message_and_loses_no_piece(
    suffix: str, expected_files: dict[str, bytes], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out = tmp_path / f"out{suffix}"
    real_fsync, handles = os.fsync, list[int]()

    def fsync_until_full(handle: int) -> None:
        # The disk has room for the manifest and three pieces.
        if len(handles) == 4:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        handles.append(handle)
        real_fsync(handle)

    monkeypatch.setattr(os, "fsync", fsync_until_full)
    for _ in range(2):
        with pytest.raises(ComputationError, match=r"No space left.*; 9 of 20 members are kept"):
            run(out)
        assert not [name for name in names(out.with_name(f"{out.name}.parts")) if "tmp" in name]
    monkeypatch.undo()
    assert run(out).stored_before == 9
    assert out.read_bytes() == expected_files[suffix]


def test_no_room_for_the_merged_file_keeps_the_pieces(
    expected_files: dict[str, bytes], tmp_path: Path
) -> None:
    # The system's limit of file sizes imitates a full disk: pieces fit, the complete file does not.
    out = tmp_path / "out.csv"
    with file_size_limit(1800), pytest.raises(ComputationError, match="20 of 20 members are kept"):
        run(out)
    assert not out.exists()
    assert run(out) == WriteSummary(members=20, failed=5, stored_before=20)
    assert out.read_bytes() == expected_files[".csv"]


def test_a_second_process_on_the_same_sweep_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    parts = interrupt(out)
    with hold_lock(parts / "lock", "somebody"), pytest.raises(InputError, match="another fivtui"):
        run(out)
    run(out)


def test_a_file_that_appears_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    out = tmp_path / "out.csv"

    def progress(_fraction: float) -> bool:
        out.write_text("mine")
        return True

    with pytest.raises(InputError, match="exists already"):
        run(out, progress=progress)
    assert out.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "message"), [("out.txt", ".csv, .parquet"), ("none/out.csv", "no folder")]
)
def test_a_file_that_cannot_be_written_is_refused_at_once(
    name: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        run(tmp_path / name)
    assert names(tmp_path) == []


def test_default_pieces_take_about_a_second_and_are_not_empty() -> None:
    assert default_piece_size(dataclasses.replace(STUDY, t_end=1e7)) == 1
    assert default_piece_size(dataclasses.replace(STUDY, t_end=100.0)) == 10_000
    assert default_piece_size(dataclasses.replace(STUDY, t_end=1e-3)) == 20_000


COMMAND = [
    "sweep", "--vary=F=10:120:100", "--vary=mu=0.1:1:5", "--both", "--t-end=30",
    "--output=y_abs", "--piece=20", "--workers=2",
]  # fmt: skip


@contextmanager
def start_program(out: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The command as a process."""
    with subprocess.Popen(
        [sys.executable, "-m", "fivtui", *COMMAND, f"--out={out}"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    ) as process:
        yield process


@pytest.mark.parametrize("times", [1, pytest.param(100, marks=pytest.mark.whole)])
def test_the_program_killed_at_random_times_leaves_the_same_file(
    tmp_path: Path, times: int
) -> None:
    complete, out = tmp_path / "complete.parquet", tmp_path / "out.parquet"
    with start_program(complete) as process:
        assert process.wait() == 0
    rng, kills = random.Random(6), 0
    parts = tmp_path / "out.parquet.parts"
    for _ in range(times):
        with start_program(out) as process:
            # Wait for a new piece, then kill at a random time.
            piece_count = len(list(parts.glob("0*")))
            while process.poll() is None and len(list(parts.glob("0*"))) == piece_count:
                time.sleep(0.002)
            time.sleep(rng.uniform(0.0, 0.05))
            process.kill()
            kills += process.wait() == -signal.SIGKILL
    assert kills > 0
    with start_program(out) as process:
        assert process.wait() == 0
    assert out.read_bytes() == complete.read_bytes()
    assert names(tmp_path) == ["complete.parquet", "out.parquet"]

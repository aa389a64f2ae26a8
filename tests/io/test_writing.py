"""Atomic writing of one or several files, and temporary files that killed runs leave."""

import errno
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import BinaryIO

import pytest

from fivtui.cli import EXIT_COMPUTATION, EXIT_INPUT, run
from fivtui.io import (
    output_path,
    publish_together,
    save_bytes,
    system_limit_error,
    temporary_folder,
    write_atomically,
)
from fivtui.model import ComputationError, InputError
from fivtui.tui.session import crash_message

from .test_files import file_size_limit, names

# Writes half of a file, prints a line, and waits to be killed.
HALF = """
import sys
from pathlib import Path
from fivtui.io import write_atomically

def write(file):
    file.write(b"half")
    file.flush()
    print("half", flush=True)
    sys.stdin.read()

write_atomically(Path(sys.argv[1]), write)
"""


def start_writing(path: Path) -> subprocess.Popen[str]:
    """A process that has written half of the file `path` and waits."""
    process = subprocess.Popen(
        [sys.executable, "-c", HALF, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "half\n"
    return process


def save_together(contents: dict[str, bytes], folder: Path, *, force: bool) -> None:
    with publish_together():
        for name, content in contents.items():
            save_bytes(content, output_path(folder / name, force=force))


def end(process: subprocess.Popen[str], *, kill: bool) -> None:
    if kill:
        process.kill()
    process.communicate()
    assert (process.returncode == 0) is not kill


def test_the_next_run_of_the_same_output_removes_files_of_a_killed_run(tmp_path: Path) -> None:
    path, second_path = tmp_path / "map.csv", tmp_path / "other.csv"
    end(start_writing(path), kill=True)
    (temporary,) = names(tmp_path)
    assert temporary.endswith(".tmp")
    save_bytes(b"another output", second_path)
    assert names(tmp_path) == [temporary, "other.csv"]
    save_bytes(b"new", path)
    assert names(tmp_path) == ["map.csv", "other.csv"]


def test_a_run_that_still_writes_the_same_output_keeps_its_file(tmp_path: Path) -> None:
    path = tmp_path / "map.csv"
    living = start_writing(path)
    save_bytes(b"new", path)
    assert len(names(tmp_path)) == 2
    # The living run may not replace a file.
    path.unlink()
    end(living, kill=False)
    assert path.read_bytes() == b"half"
    assert names(tmp_path) == ["map.csv"]


def test_many_runs_that_write_the_same_output_at_once_all_finish(tmp_path: Path) -> None:
    path, together = tmp_path / "map.csv", Barrier(8)

    def write(number: int) -> None:
        together.wait()
        for _ in range(20):
            save_bytes(bytes([number]) * 10_000, output_path(path, force=True))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(write, range(8)))
    assert len({*path.read_bytes()}) == 1
    assert names(tmp_path) == ["map.csv"]


def test_a_temporary_file_that_another_run_removed_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Another run removes the file between its creation and the lock.
    from fivtui.io import writing

    removed: list[str] = []

    def lock_late(handle: int) -> None:
        if not removed:
            removed.extend(names(tmp_path))
            (tmp_path / removed[0]).unlink()

    monkeypatch.setattr(writing, "lock_file", lock_late)
    save_bytes(b"new", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_bytes() == b"new"
    assert len(removed) == 1


def test_without_file_locks_files_are_written_and_none_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    end(start_writing(tmp_path / "out.csv"), kill=True)

    def refuse(handle: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fivtui.io.writing.lock_file", refuse)
    save_bytes(b"new", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_bytes() == b"new"
    assert len(names(tmp_path)) == 2


def test_files_written_together_appear_at_the_end(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    with publish_together():
        save_bytes(b"1", first)
        assert not first.exists()
        save_bytes(b"2", second)
    assert (first.read_bytes(), second.read_bytes()) == (b"1", b"2")
    assert names(tmp_path) == ["first", "second"]


@pytest.mark.parametrize("force", [False, True])
def test_of_a_set_that_does_not_fit_nothing_is_written(tmp_path: Path, force: bool) -> None:
    old = {"first": b"old"} if force else {}
    for name, content in old.items():
        (tmp_path / name).write_bytes(content)
    contents = {"first": b"1", "second": bytes(20_000)}
    with file_size_limit(10_000), pytest.raises(InputError, match="second: cannot be written"):
        save_together(contents, tmp_path, force=force)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == old


def test_no_file_of_a_set_is_written_if_one_name_exists_meanwhile(tmp_path: Path) -> None:
    def write(file: BinaryIO) -> None:
        file.write(b"2")
        (tmp_path / "second").touch()

    def write_both() -> None:
        with publish_together():
            save_bytes(b"1", tmp_path / "first")
            write_atomically(tmp_path / "second", write)

    with pytest.raises(InputError, match="second: exists already"):
        write_both()
    assert names(tmp_path) == ["second"]


def test_a_file_that_the_writer_of_another_saves_appears_before_the_set(tmp_path: Path) -> None:
    part = tmp_path / "part"

    def write(file: BinaryIO) -> None:
        save_bytes(b"part", part)
        file.write(part.read_bytes())

    with publish_together():
        write_atomically(tmp_path / "out", write)
    assert (tmp_path / "out").read_bytes() == b"part"


def test_a_temporary_folder_that_is_full_is_named_with_advice() -> None:
    folders: list[Path] = []

    def fill() -> None:
        with temporary_folder() as folder:
            folders.append(folder)
            (folder / "large").write_bytes(bytes(20_000))

    with file_size_limit(10_000), pytest.raises(ComputationError) as error:
        fill()
    assert str(error.value).startswith("the folder for temporary files, ")
    assert str(error.value).endswith("; raise the limit on the size of files (ulimit -f)")
    assert not folders[0].exists()


def test_only_errors_at_limits_of_the_system_such_as_a_full_disk_are_expected() -> None:
    assert system_limit_error(FileNotFoundError(errno.ENOENT, "none")) is None
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "film.gif")
    assert str(system_limit_error(full)) == (
        "film.gif: No space left on device; free space on the disk"
    )
    assert crash_message(full) == str(system_limit_error(full))


@pytest.mark.parametrize(
    ("command", "limit", "expected"),
    [
        ("compare --out .", 5_000, "the folder for temporary files"),
        ("animate --window 0:1 --speed 5 --out film.gif", 5_000, "the folder for temporary files"),
        ("figures 2 --out .", 5_000, "fig-02.pdf: cannot be written"),
        ("figures 2 --out .", 40_000, "fig-02.png: cannot be written"),
    ],
)
def test_a_limit_on_the_file_size_is_a_one_line_error_and_leaves_no_files(
    command: str,
    limit: int,
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with file_size_limit(limit):
        assert run(command.split()) in (EXIT_INPUT, EXIT_COMPUTATION)
    message = capsys.readouterr().err
    assert expected in message.splitlines()[-1]
    # Only messages of unexpected errors ask to report them.
    assert "report" not in message
    assert "unexpected" not in message
    assert names(tmp_path) == []

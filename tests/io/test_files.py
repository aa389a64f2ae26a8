"""Output files."""

import os
import resource
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import pytest

from fivtui.io import output_path
from fivtui.io.files import check_output, check_suffix
from fivtui.io.writing import write_atomically
from fivtui.model.errors import InputError


def write_new(file: BinaryIO) -> None:
    file.write(b"new")


@contextmanager
def file_size_limit(size: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    # The limit would truncate the bytecode that Python stores for modules imported in the context.
    bytecode_off, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        sys.dont_write_bytecode = bytecode_off


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_new_file_has_the_content_and_the_usual_permissions(tmp_path: Path) -> None:
    path, usual = tmp_path / "out.csv", tmp_path / "usual"
    usual.touch()
    write_atomically(path, write_new)
    assert path.read_bytes() == b"new"
    assert path.stat().st_mode == usual.stat().st_mode
    assert names(tmp_path) == ["out.csv", "usual"]


def test_an_existing_file_is_replaced_only_by_force(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_bytes(b"old")
    path.chmod(0o640)
    with pytest.raises(InputError, match=r"out\.csv: exists already"):
        check_output(path)
    with pytest.raises(InputError, match="exists already"):
        write_atomically(path, write_new)
    assert path.read_bytes() == b"old"
    # With `force` the path is of a type that lets a writer replace the file.
    write_atomically(output_path(path, force=True), write_new)
    assert path.read_bytes() == b"new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"out\.csv: there is no folder .*nowhere$"):
        check_output(tmp_path / "nowhere" / "out.csv")


@pytest.mark.parametrize("force", [False, True])
def test_special_files_are_never_replaced(tmp_path: Path, force: bool) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, reason in ((tmp_path, "is a folder"), (tmp_path / "pipe", "not a regular file")):
        with pytest.raises(InputError, match=reason):
            check_output(output_path(path, force=force))
        with pytest.raises(InputError, match=reason):
            write_atomically(output_path(path, force=force), write_new)


@pytest.mark.parametrize("name", ["a\0b", "x" * 300 + ".csv"])
def test_an_impossible_name_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError):
        check_output(tmp_path / name)


def test_the_longest_name_can_be_written(tmp_path: Path) -> None:
    path = tmp_path / ("x" * 255)
    write_atomically(path, write_new)
    assert path.read_bytes() == b"new"


def test_missing_permission_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_bytes(b"old")
    path.chmod(0o400)
    tmp_path.chmod(0o500)
    try:
        if os.access(path, os.W_OK):
            pytest.skip("this user may write everywhere")
        with pytest.raises(InputError, match="the file is read-only"):
            check_output(output_path(path, force=True))
        with pytest.raises(InputError, match="no permission to write in"):
            check_output(tmp_path / "new.csv")
    finally:
        tmp_path.chmod(0o700)


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_bytes(b"old")

    def write(file: BinaryIO) -> None:
        file.write(bytes(100_000))

    with (
        file_size_limit(10_000),
        pytest.raises(InputError, match=r"out\.csv: cannot be written: \w+") as caught,
    ):
        write_atomically(output_path(path, force=True), write)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["out.csv"]


def test_an_error_while_writing_passes_and_leaves_nothing(tmp_path: Path) -> None:
    def write(file: BinaryIO) -> None:
        file.write(b"half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "out.csv", write)
    assert names(tmp_path) == []


def test_a_file_that_appears_while_writing_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"

    def write(file: BinaryIO) -> None:
        file.write(b"new")
        path.write_bytes(b"someone else's")

    with pytest.raises(InputError, match="exists already"):
        write_atomically(path, write)
    assert path.read_bytes() == b"someone else's"
    assert names(tmp_path) == ["out.csv"]


def test_a_symbolic_link_stays_and_its_target_is_written(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    link = tmp_path / "link.csv"
    link.symlink_to(folder / "target.csv")
    write_atomically(link, write_new)
    assert link.is_symlink()
    assert (folder / "target.csv").read_bytes() == b"new"


def test_suffixes_are_matched_in_any_case_and_otherwise_listed() -> None:
    assert check_suffix(Path("A.PNG"), "figure", (".png", ".svg")) == ".png"
    with pytest.raises(InputError, match=r"a\.jpg: .* figure .* \.png, \.svg$"):
        check_suffix(Path("a.jpg"), "figure", (".png", ".svg"))

"""Table files: named columns with units, under a header that records how they were computed."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, Final, Protocol

from numpy.typing import NDArray

from fivtui.model import Column, InputError
from fivtui.version import __version__

from . import csv_format, npz_format, parquet_format
from .files import check_output, check_suffix
from .reading import open_regular
from .writing import write_atomically

Columns = dict[str, NDArray[Any]]
Header = Mapping[str, Any]


class Format(Protocol):
    """A format of table files: a module with functions on binary files."""

    @property
    def package(self) -> str:
        """Package that the format needs besides the dependencies of fivtui; empty if none."""

    @property
    def extra(self) -> str:
        """The extra of fivtui that installs the package."""

    def write(
        self, file: BinaryIO, columns: Sequence[Column], values: Columns, header: Header
    ) -> None:
        """Write columns of numbers of equal length, and a header of JSON values."""

    def read(
        self,
        file: BinaryIO,
        selected: Collection[str] | None = None,
        texts: Collection[str] = (),
        *,
        missing: bool = False,
    ) -> Columns:
        """Read all columns, or those of `selected` that exist; `InputError` if damaged.

        Columns in `texts` become arrays of str, all others arrays of numbers. With `missing`, cells
        may be empty, true or false; they become NaN, 1 and 0.
        """

    def header(self, file: BinaryIO) -> dict[str, Any]:
        """Read the header; `InputError` if the file is damaged."""


FORMATS: Final[Mapping[str, Format]] = {
    ".csv": csv_format,
    ".npz": npz_format,
    ".parquet": parquet_format,
}


def table_format(path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS)) -> Format:
    """The format of a file by its suffix, one of `allowed`; messages call it a `kind` file.

    Raises `InputError` if the suffix is not allowed, or the format's package is missing.
    """
    file_format = FORMATS[check_suffix(path, kind, allowed)]
    if file_format.package and find_spec(file_format.package) is None:
        raise InputError(
            f"{path}: this format needs {file_format.package}: install fivtui[{file_format.extra}]"
        )
    return file_format


def check_table_path(path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS)) -> None:
    """Raise `InputError` if a table cannot be written; call it before the computation."""
    table_format(path, kind, allowed)
    check_output(path)


def write_table(
    path: Path, kind: str, columns: Sequence[Column], values: Columns, header: Header
) -> None:
    """Write a table of numbers; equal tables give equal bytes."""
    file_format = table_format(path, kind)

    def write(file: BinaryIO) -> None:
        file_format.write(file, columns, values, {"fivtui": __version__, **header})

    write_atomically(path, write)


def read_columns(
    path: Path,
    kind: str,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,
) -> Columns:
    """Read columns of a table file by name, see `Format.read`; `InputError` if that fails."""
    file_format = table_format(path, kind)
    with _open_table(path, kind) as file:
        return file_format.read(file, selected, texts, missing=missing)


def read_header(path: Path, kind: str) -> dict[str, Any]:
    """Read the header of a table file; `InputError` if that fails."""
    file_format = table_format(path, kind)
    with _open_table(path, kind) as file:
        return file_format.header(file)


@contextmanager
def _open_table(path: Path, kind: str) -> Iterator[BinaryIO]:
    with open_regular(path) as file:
        try:
            yield file
        except InputError as error:
            raise InputError(f"{path}: not a {kind}: {error}") from None

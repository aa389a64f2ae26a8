"""Table files: named columns with units under a header of provenance."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, Final, Protocol

from numpy.typing import NDArray

from fivtui.model import Column, InputError
from fivtui.version import __version__

from . import csv_format, npz_format, parquet_format
from .files import check_output, check_suffix
from .reading import opened
from .writing import write_atomically

Columns = dict[str, NDArray[Any]]
Header = Mapping[str, Any]


class _Write(Protocol):
    def __call__(
        self, file: BinaryIO, columns: Sequence[Column], values: Columns, header: Header
    ) -> None: ...


class _Read(Protocol):
    def __call__(
        self,
        file: BinaryIO,
        wanted: Collection[str] | None = None,
        texts: Collection[str] = (),
        *,
        missing: bool = False,
    ) -> Columns: ...


class _ReadHeader(Protocol):
    def __call__(self, file: BinaryIO) -> dict[str, Any]: ...


@dataclass(frozen=True, slots=True)
class Format:
    """A format of table files, with functions on binary files.

    Attributes
    ----------
    write : callable
        Writes columns of numbers of equal length, and a header of JSON values.
    read : callable
        Reads all columns, or those `wanted` that are there, in the order of the file. Columns in
        `texts` become arrays of str, all others numbers; with `missing`, NaN for no value, and 1
        and 0 for true and false. InputError if the file is of another format or damaged.
    header : callable
        Reads the header alone; InputError as `read`.
    package : str
        Package that it needs beside fivtui's own dependencies; empty if none.
    extra : str
        The extra of fivtui that installs the package.
    """

    write: _Write
    read: _Read
    header: _ReadHeader
    package: str = ""
    extra: str = ""

    def check_installed(self) -> None:
        """Raise `InputError` if its package is missing."""
        if self.package and find_spec(self.package) is None:
            raise InputError(f"this format needs {self.package}: install fivtui[{self.extra}]")


FORMATS: Final[Mapping[str, Format]] = {
    ".csv": Format(csv_format.write, csv_format.read_csv, csv_format.header),
    ".npz": Format(npz_format.write, npz_format.read, npz_format.header),
    ".parquet": Format(
        parquet_format.write,
        parquet_format.read,
        parquet_format.header,
        package="pyarrow",
        extra="parquet",
    ),
}


def table_format(path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS)) -> Format:
    """The format of a file by its suffix, one of `allowed`; `kind` names the file in messages.

    Raises `InputError` if the suffix is another one, or the format's package is missing.
    """
    form = FORMATS[check_suffix(path, kind, allowed)]
    try:
        form.check_installed()
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return form


def check_table_path(
    path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS), *, force: bool
) -> None:
    """Raise `InputError` if a table could not be written, before it is computed."""
    table_format(path, kind, allowed)
    check_output(path, force=force)


def write_table(
    path: Path,
    kind: str,
    columns: Sequence[Column],
    values: Columns,
    header: Header,
    *,
    force: bool = False,
) -> None:
    """Write a table of numbers; equal tables give equal bytes."""
    form = table_format(path, kind)

    def write(file: BinaryIO) -> None:
        form.write(file, columns, values, {"fivtui": __version__, **header})

    write_atomically(path, write, force=force)


def read_columns(
    path: Path,
    kind: str,
    wanted: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,
) -> Columns:
    """Columns of a table file by name, see `Format.read`; `InputError` if it cannot be read."""
    form = table_format(path, kind)
    with _read(path, kind) as file:
        return form.read(file, wanted, texts, missing=missing)


def read_header(path: Path, kind: str) -> dict[str, Any]:
    """The header of a table file, empty if it has none; `InputError` as `read_columns`."""
    form = table_format(path, kind)
    with _read(path, kind) as file:
        return form.header(file)


@contextmanager
def _read(path: Path, kind: str) -> Iterator[BinaryIO]:
    with opened(path) as file:
        try:
            yield file
        except InputError as error:
            raise InputError(f"{path}: not a {kind}: {error}") from None

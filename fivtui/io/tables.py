"""Table files: named columns with units, and a header that says what they are of."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, Final, Protocol

from numpy.typing import NDArray

from fivtui.model import Column, InputError
from fivtui.version import __version__

from . import csv_format, npz_format, parquet_format
from .files import check_output, check_suffix, write_atomically
from .reading import opened

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
    """A format of table files; what it reads and writes are binary files.

    Attributes
    ----------
    write : callable
        Writes columns of numbers, equally long, and a header of JSON values.
    read : callable
        Reads columns in the order of the file: all, or those `wanted` that are there. Those named
        `texts` are arrays of str; all others must be numbers. With `missing`, NaN stands for no
        value, 1 and 0 for true and false. InputError if the file is of another format or damaged.
    header : callable
        Reads the header alone; InputError as `read`.
    package : str
        Package that it needs besides those that fivtui always needs; empty if none.
    extra : str
        The extra of fivtui that installs the package.
    """

    write: _Write
    read: _Read
    header: _ReadHeader
    package: str = ""
    extra: str = ""

    def check_installed(self) -> None:
        """Raise `InputError` if a package is missing; the message says how to install it."""
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
    """The format that the name of a file says.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it holds, named in messages, e.g. ``"trajectory"``.
    allowed : collection of str
        The suffixes allowed, keys of `FORMATS`.

    Returns
    -------
    Format
        Its format.

    Raises
    ------
    InputError
        If the suffix is not among those allowed, or a package that the format needs is missing.
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
    """Check that a table can be written to a file, before it is computed.

    Parameters
    ----------
    path, kind, allowed
        As in `table_format`.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        As `table_format` and `check_output`.
    """
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
    """Write a table of numbers; the same table always gives the same bytes.

    Parameters
    ----------
    path, kind
        As in `table_format`.
    columns : sequence of Column
        Names, units and meanings, in the order of the file.
    values : mapping of str to ndarray, shape (n,)
        Values by name.
    header : mapping
        What the file says beside them, as JSON can hold it; the version of fivtui comes first.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        As `table_format`, or if the file cannot be written.
    """
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
    """Read the columns of a table file.

    Parameters
    ----------
    path, kind
        As in `table_format`.
    wanted, texts, missing
        As in `Format.read`.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        Values by name.

    Raises
    ------
    InputError
        If the file cannot be read, is of another format than its name says, or damaged.
    """
    form = table_format(path, kind)
    with opened(path) as file:
        try:
            return form.read(file, wanted, texts, missing=missing)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None


def read_header(path: Path, kind: str) -> dict[str, Any]:
    """Read what a table file says beside its columns; empty if it says nothing.

    Parameters
    ----------
    path, kind
        As in `table_format`.

    Returns
    -------
    dict
        Values by key.

    Raises
    ------
    InputError
        As `read_columns`.
    """
    form = table_format(path, kind)
    with opened(path) as file:
        try:
            return form.header(file)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None

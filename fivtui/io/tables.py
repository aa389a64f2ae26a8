"""Table files: named columns with units under a header of provenance."""

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
from .reading import opened
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

        Columns in `texts` become arrays of str, all others numbers; with `missing`, NaN for no
        value, and 1 and 0 for true and false.
        """

    def header(self, file: BinaryIO) -> dict[str, Any]:
        """Read the header alone; `InputError` as `read`."""


FORMATS: Final[Mapping[str, Format]] = {
    ".csv": csv_format,
    ".npz": npz_format,
    ".parquet": parquet_format,
}


def table_format(path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS)) -> Format:
    """The format of a file by its suffix, one of `allowed`; `kind` names the file in messages.

    Raises `InputError` if the suffix is not allowed, or the format's package is missing.
    """
    form = FORMATS[check_suffix(path, kind, allowed)]
    if form.package and find_spec(form.package) is None:
        raise InputError(f"{path}: this format needs {form.package}: install fivtui[{form.extra}]")
    return form


def check_table_path(path: Path, kind: str, allowed: Collection[str] = tuple(FORMATS)) -> None:
    """Raise `InputError` if a table could not be written, before it is computed."""
    table_format(path, kind, allowed)
    check_output(path)


def write_table(
    path: Path,
    kind: str,
    columns: Sequence[Column],
    values: Columns,
    header: Header,
) -> None:
    """Write a table of numbers; equal tables give equal bytes."""
    form = table_format(path, kind)

    def write(file: BinaryIO) -> None:
        form.write(file, columns, values, {"fivtui": __version__, **header})

    write_atomically(path, write)


def read_columns(
    path: Path,
    kind: str,
    selected: Collection[str] | None = None,
    texts: Collection[str] = (),
    *,
    missing: bool = False,
) -> Columns:
    """Columns of a table file by name, see `Format.read`; `InputError` if it cannot be read."""
    form = table_format(path, kind)
    with _read(path, kind) as file:
        return form.read(file, selected, texts, missing=missing)


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

"""Results that tables hold: columns with units under a header, written and read in every format."""

import json
from collections.abc import Callable, Collection, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from numpy.typing import NDArray

from fivtui.io import Columns, Header, read_bytes, read_columns, read_header, write_table
from fivtui.model import Column, InputError

from .base import SystemResult
from .grid import FloatArray, Grid

if TYPE_CHECKING:
    import xarray

Table = dict[Column, NDArray[Any]]
T = TypeVar("T")


class Tabular:
    """Base of results that a table holds, whose columns a class declares by `_table`."""

    __slots__ = ()

    def _table(self) -> Table:
        raise NotImplementedError

    def _header(self) -> dict[str, Any]:
        # What the table does not say, as data for JSON.
        return {}

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """The columns of its table by name, arrays of equal length; NaN means no value."""
        return by_name(self._table())

    def to_xarray(self) -> "xarray.Dataset":
        """Its columns as an xarray Dataset with units; over its grid, or over the rows.

        Raises `InputError` if xarray is not installed.
        """
        if find_spec("xarray") is None:
            raise InputError("to_xarray needs xarray: install fivtui[xarray]")
        import xarray

        table = self._table()
        grid = self._grid()
        shape = None if grid is None else grid.shape
        axes = {} if grid is None else dict(zip(grid.names, grid.axes, strict=True))
        dims = tuple(axes) or ("row",)
        variables = {
            c.name: (dims, values.reshape(shape or values.shape), _attributes(c))
            for c, values in table.items()
            if c.name not in axes
        }
        coordinates = {
            c.name: (c.name, axes[c.name], _attributes(c)) for c in table if c.name in axes
        }
        return xarray.Dataset(variables, coordinates, self._header())

    def _grid(self) -> Grid | None:
        # The grid whose points are the rows of its table, if there is one.
        return None


class TableResult(SystemResult, Tabular):
    """Base of results about one system that a table holds, in a file or in memory."""

    __slots__ = ()

    data_name: ClassVar[str]

    def _header(self) -> dict[str, Any]:
        return self._system_data()


class GridResult(TableResult):
    """Base of results over all pairs of the values of two quantities, which `grid` holds."""

    __slots__ = ()

    grid: Grid

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two quantities."""
        return self.grid.names

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Their values, shapes (n,) and (k,)."""
        return self.grid.axes

    def _grid(self) -> Grid:
        return self.grid


def _attributes(column: Column) -> dict[str, str]:
    return {"units": column.unit, "long_name": column.meaning}


def save_result(result: TableResult, path: Path) -> None:
    """Write a result as ``.csv``, ``.npz`` or ``.parquet``.

    Raises `InputError` if the format is unknown or its package missing, or the file cannot be
    written.
    """
    save_table(path, result.data_name, result._table(), result._header())


def save_table(path: Path, data_name: str, table: Table, header: Header) -> None:
    """Write columns under a header; `data_name` says in messages what the file holds."""
    write_table(path, data_name, list(table), by_name(table), header)


def by_name(table: Table) -> dict[str, NDArray[Any]]:
    """The columns of a table by name."""
    return {column.name: values for column, values in table.items()}


def read_result(
    path: Path,
    data_name: str,
    from_data: Callable[[Any], T],
    from_table: Callable[[Columns, Mapping[str, Any]], T] | None = None,
    *,
    texts: Collection[str] = (),
    missing: bool = False,
) -> T:
    """Read a result from a table, or from the JSON that the command line prints."""
    content, columns, header = b"", {}, {}
    if path.suffix.lower() == ".json":
        content = read_bytes(path)
    elif from_table is None:
        raise InputError(
            f"{path}: a {data_name} is read from JSON alone, which {data_name} --json prints"
        )
    else:
        columns = read_columns(path, data_name, texts=texts, missing=missing)
        header = read_header(path, data_name)
    try:
        return (
            from_table(columns, header)
            if columns and from_table
            else from_data(json.loads(content))
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
        raise InputError(f"{path}: not a {data_name}, or damaged") from None

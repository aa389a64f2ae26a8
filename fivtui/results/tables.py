"""Results as tables: columns with units under a header, in every file format."""

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
    """Base of results with a table; a subclass returns its columns from `_table`."""

    __slots__ = ()

    def _table(self) -> Table:
        raise NotImplementedError

    def _header(self) -> dict[str, Any]:
        # Data for JSON beside the columns, such as the parameters.
        return {}

    def to_columns(self) -> dict[str, NDArray[Any]]:
        """The columns of the table by name, arrays of equal length; NaN means no value."""
        return columns_by_name(self._table())

    def to_xarray(self) -> "xarray.Dataset":
        """The columns as an xarray Dataset with units, over the grid or, without a grid, over rows.

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
            column.name: (dims, values.reshape(shape or values.shape), _attributes(column))
            for column, values in table.items()
            if column.name not in axes
        }
        coordinates = {
            column.name: (column.name, axes[column.name], _attributes(column))
            for column in table
            if column.name in axes
        }
        return xarray.Dataset(variables, coordinates, self._header())

    def _grid(self) -> Grid | None:
        # The grid whose points are the rows of the table; None without a grid.
        return None


class TableResult(SystemResult, Tabular):
    """Base of results about one system with a table, in a file or in memory."""

    __slots__ = ()

    data_name: ClassVar[str]

    def _header(self) -> dict[str, Any]:
        return self._system_data()


class GridResult(TableResult):
    """Base of results at all points of a grid of two quantities."""

    __slots__ = ()

    grid: Grid

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two quantities."""
        return self.grid.names

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Values of the two quantities, shapes (n,) and (k,)."""
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
    """Write columns under a header; `data_name` names the contents of the file in messages."""
    write_table(path, data_name, list(table), columns_by_name(table), header)


def columns_by_name(table: Table) -> dict[str, NDArray[Any]]:
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
    """Read a result from a table or JSON.

    `from_data` converts the JSON value of a file, `from_table` the columns and the header of a
    table; without it, only JSON is read. `texts` are the columns of text; with `missing`, cells may
    be empty, true or false. `data_name` names the contents of the file in messages.
    """
    if path.suffix.lower() == ".json":
        content = read_bytes(path)

        def convert() -> T:
            return from_data(json.loads(content))
    elif from_table is None:
        # Such contents have the name of the command that computes them.
        raise InputError(
            f"{path}: a {data_name} is read from JSON alone, which {data_name} --json prints"
        )
    else:
        columns = read_columns(path, data_name, texts=texts, missing=missing)
        header = read_header(path, data_name)

        def convert() -> T:
            return from_table(columns, header)

    try:
        return convert()
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
        raise InputError(f"{path}: not a {data_name}, or damaged") from None

"""Grids of two quantities, as arrays, as columns of tables and as data for JSON."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Column, InputError, ParameterSpec

from .base import Comparable

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Grid(Comparable):
    """All pairs of the values of two quantities; tables list them with the second varying fastest.

    Attributes
    ----------
    specs : tuple of ParameterSpec
        The two quantities: parameters, or components of the state at t = 0.
    axes : tuple of ndarray, shapes (n,) and (k,)
        Their values.
    """

    specs: tuple[ParameterSpec, ParameterSpec]
    axes: tuple[FloatArray, FloatArray]

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two quantities."""
        first, second = self.specs
        return first.name, second.name

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of values, n and k."""
        first, second = self.axes
        return first.size, second.size

    @property
    def size(self) -> int:
        """Number of points, n k."""
        rows, columns = self.shape
        return rows * columns

    def meshes(self) -> dict[str, FloatArray]:
        """The values of both quantities at all points, shapes (n, k), by name."""
        return dict(zip(self.names, np.meshgrid(*self.axes, indexing="ij"), strict=True))

    def table(self) -> dict[Column, FloatArray]:
        """The values of both quantities at all points as columns of a table."""
        meshes = self.meshes()
        return {spec.column: meshes[spec.name].ravel() for spec in self.specs}

    def to_data(self) -> list[dict[str, Any]]:
        """Name, unit and values of both quantities as data for JSON."""
        return [
            {"name": spec.name, "unit": spec.unit, "values": axis.tolist()}
            for spec, axis in zip(self.specs, self.axes, strict=True)
        ]


def build_grid(
    argument: str,
    over: Mapping[str, Sequence[float] | FloatArray],
    find_spec: Callable[[str], ParameterSpec],
) -> Grid:
    """A grid of two quantities from their names and values.

    `argument` names the argument in error messages; `find_spec` returns the spec of a name. Raises
    `InputError` if a quantity has no values, or a value is out of range.
    """
    first, second = (find_spec(name) for name in over)
    axes = [np.array(values, dtype=float) for values in over.values()]
    for spec, axis in zip((first, second), axes, strict=True):
        if axis.ndim != 1 or axis.size == 0:
            raise InputError(f"{argument}: {spec.name}: must be one or more numbers")
        for bound in (axis.min(), axis.max()):
            spec.check(float(bound))
    return Grid((first, second), (axes[0], axes[1]))


def axes_from_data(data: Sequence[Mapping[str, Any]]) -> dict[str, FloatArray]:
    """The axis values of a grid by name, from the data of `Grid.to_data`."""
    return {str(axis["name"]): np.array(axis["values"], dtype=float) for axis in data}


def split_grid(
    columns: Mapping[str, NDArray[Any]],
) -> tuple[dict[str, FloatArray], dict[str, NDArray[Any]]]:
    """Split the columns of a table into the axes of its grid and arrays over the grid.

    The first two columns are the quantities of the grid; the second one varies fastest.
    """
    first, second, *quantities = columns
    # The first quantity is constant while the second one takes all its values. `argmax` gives the
    # index of its first change, or 0 if it never changes.
    is_changed = columns[first] != columns[first][0]
    second_size = int(np.argmax(is_changed)) or is_changed.size
    arrays = {name: column.reshape(-1, second_size) for name, column in columns.items()}
    first_axis, second_axis = arrays[first][:, :1], arrays[second][0]
    if not (np.all(arrays[first] == first_axis) and np.all(arrays[second] == second_axis)):
        raise InputError("the points do not form a grid")
    axes = {first: first_axis.ravel(), second: second_axis}
    return axes, {name: arrays[name] for name in quantities}

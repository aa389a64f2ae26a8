"""Entry of maps over two parameters in the registry of studies.

The keys in `header` identify a map in the header of a saved table, those in `json_keys` in a JSON
object.
"""

from operator import attrgetter, methodcaller
from typing import TYPE_CHECKING, Final

from fivtui.lazy import lazy_modules
from fivtui.ranges import range_text
from fivtui.results import TABLE_SUFFIXES, Command, Storage, StudyKind, command_for, list_printer

from .options import MapOptions

if TYPE_CHECKING:
    from .result import StabilityMap

(files,) = lazy_modules(__name__, "files")
_BYTES_PER_NUMBER: Final = 8


def _stored_size(result: "StabilityMap") -> int:
    # Bytes of a table with two columns of parameters and one for each quantity.
    return (2 + len(result.quantities)) * _BYTES_PER_NUMBER * result.grid.size


def _command(result: "StabilityMap") -> Command:
    # The command that computes a map.
    over = tuple(
        f"{name}={range_text(name, axis)}"
        for name, axis in zip(result.names, result.axes, strict=True)
    )
    options = MapOptions(over=over, value=result.value)
    return command_for("map", result, options, varied=result.names)


MAP: Final = StudyKind(
    contents_name="map",
    show=list_printer(attrgetter("title"), methodcaller("rows")),
    rows=methodcaller("rows"),
    failure=attrgetter("failure"),
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"map-{'-'.join(result.names)}",
    load=files.load_map,
    header_keys=frozenset({"parameters", "separation"}),
    json_keys=frozenset({"over", "values"}),
    command=_command,
    storage=Storage(".npz", size=_stored_size),
)

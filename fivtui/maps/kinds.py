"""Maps among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.console import print_rows_of
from fivtui.lazy import later
from fivtui.ranges import range_text
from fivtui.results import TABLES, Command, Stored, StudyKind, command_for

from .options import MapOptions

if TYPE_CHECKING:
    from .result import StabilityMap

(files,) = later(__name__, "files")
_BYTES: Final = 8


def _show(result: "StabilityMap") -> None:
    print_rows_of(result.title, result.rows())


def _command(result: "StabilityMap") -> Command:
    over = tuple(
        f"{name}={range_text(name, axis)}"
        for name, axis in zip(result.names, result.axes, strict=True)
    )
    options = MapOptions(over=over, value=result.value)
    return command_for("map", result, options, varied=result.names)


def _size(result: "StabilityMap") -> int:
    return (2 + len(result.quantities)) * _BYTES * result.grid.size


MAP: Final = StudyKind(
    data="map",
    show=_show,
    rows=lambda result: result.rows(),
    suffixes=TABLES,
    as_json=True,
    stem=lambda result: f"map-{'-'.join(result.names)}",
    load=files.load_map,
    header=frozenset({"parameters", "separation"}),
    json_keys=frozenset({"over", "values"}),
    command=_command,
    stored=Stored(".npz", size=_size),
)

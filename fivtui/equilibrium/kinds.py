"""Stability and its map among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.ranges import range_text
from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from . import figure, files, report
    from .eigenvalues import Stability
    from .map import StabilityMap
else:
    from fivtui.lazy import later

    figure, files, report = later(__name__, "figure", "files", "report")

_FORMATS: Final = tuple(FORMATS)
_BYTES: Final = 8
_DEFAULT_VALUE: Final = "growth-rate"


def _save_modes(result: "Stability", path: Path, *, force: bool) -> None:
    files.save_modes(result, result.modes_over_mu(), path, force=force)


STABILITY: Final = StudyKind(
    data="table of modes",
    show=report.print_stability,
    suffixes=_FORMATS,
    save=_save_modes,
    as_json=True,
    stem=lambda _: "stability",
    header=frozenset({"critical_mu"}),
    json_keys=frozenset({"eigenvalues", "critical_mu"}),
    command=lambda scene: Command("stability", scene_fields(scene, PHYSICS)),
)


def _map_command(result: "StabilityMap") -> Command:
    said = [name for name in PHYSICS if name not in result.names]
    words = []
    for name, axis in zip(result.names, result.axes, strict=True):
        words += ["--over", f"{name}={range_text(name, axis)}"]
    if result.value != _DEFAULT_VALUE:
        words += ["--value", result.value]
    return Command("map", scene_fields(result, PHYSICS), said, words)


MAP: Final = StudyKind(
    data="map",
    show=report.print_map,
    suffixes=_FORMATS,
    save=files.save_map,
    as_json=True,
    stem=lambda result: f"map-{'-'.join(result.names)}",
    load=files.load_map,
    load_suffixes=(*_FORMATS, ".json"),
    header=frozenset({"parameters", "separation"}),
    json_keys=frozenset({"over", "values"}),
    command=_map_command,
    stored=Stored(
        ".npz",
        files.save_map,
        files.load_map,
        lambda result: 3 * _BYTES * int(result.values.size),
    ),
)

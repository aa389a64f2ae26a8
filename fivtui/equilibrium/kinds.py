"""Stability and its map among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.ranges import range_text
from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .eigenvalues import Stability
    from .map import StabilityMap

_FORMATS: Final = (".csv", ".npz", ".parquet")
_BYTES: Final = 8
_DEFAULT_VALUE: Final = "growth-rate"


def _show_stability(result: "Stability") -> None:
    from .report import print_stability

    print_stability(result)


def _mode_figure(result: "Stability") -> "Figure":
    from .figure import mode_figure

    return mode_figure(result.parameters, result, result.modes_over_mu())


def _save_modes(result: "Stability", path: Path, force: bool) -> None:
    from .files import save_modes

    p, separation = result.parameters, result.separation
    save_modes(p, result, result.modes_over_mu(), path, separation=separation, force=force)


def _stability_command(scene: Any) -> Command:
    return Command("stability", scene_fields(scene, PHYSICS))


STABILITY: Final = StudyKind(
    data="table of modes",
    show=_show_stability,
    figure=_mode_figure,
    suffixes=_FORMATS,
    save=_save_modes,
    as_json=True,
    stem=lambda _: "stability",
    header=frozenset({"critical_mu"}),
    json_keys=frozenset({"eigenvalues", "critical_mu"}),
    command=_stability_command,
)


def _show_map(result: "StabilityMap") -> None:
    from .report import print_map

    print_map(result)


def _save_map(result: "StabilityMap", path: Path, force: bool) -> None:
    from .files import save_map

    save_map(result, path, force=force)


def _load_map(path: Path) -> "StabilityMap":
    from .files import load_map

    return load_map(path)


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
    show=_show_map,
    suffixes=_FORMATS,
    save=_save_map,
    as_json=True,
    stem=lambda result: f"map-{'-'.join(result.names)}",
    load=_load_map,
    load_suffixes=(*_FORMATS, ".json"),
    header=frozenset({"parameters", "separation"}),
    json_keys=frozenset({"over", "values"}),
    command=_map_command,
    stored=Stored(
        ".npz",
        lambda result, path: _save_map(result, path, False),
        _load_map,
        lambda result: 3 * _BYTES * int(result.values.size),
    ),
)

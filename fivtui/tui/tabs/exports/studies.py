"""Exports of stability, sweeps, maps, trade-offs and the paper. Imports no Textual."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fivtui.equilibrium import Stability
from fivtui.io import FORMATS
from fivtui.model import Parameters

from .export import FIGURE, Export, Save, data_export, figure_export, json_writer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fivtui.equilibrium import StabilityMap
    from fivtui.paper import CheckedClaim, PaperResults
    from fivtui.sweeps import Sweep
    from fivtui.tradeoffs import Tradeoff


def stability_export(
    what: str, name: str, p: Parameters, found: Stability, *, separation: bool
) -> Export:
    """Modes over μ and eigenvalues of scene `name`; `what` is `FIGURE` or `DATA`."""

    def draw() -> "Figure":
        from fivtui.equilibrium import mode_figure, modes_over_mu

        return mode_figure(p, found, modes_over_mu(p, found, separation=separation))

    def save(path: Path, force: bool) -> None:
        from fivtui.equilibrium import modes_over_mu, save_modes

        scan = modes_over_mu(p, found, separation=separation)
        save_modes(p, found, scan, path, separation=separation, force=force)

    def plain() -> object:
        from fivtui.equilibrium import stability_to_dict

        return stability_to_dict(found)

    of, stem = "the stability", f"{name}-stability"
    if what == FIGURE:
        return figure_export(of, stem, draw)
    writers = {**dict.fromkeys(FORMATS, save), ".json": json_writer(plain)}
    return data_export(of, stem, "table of modes", writers)


def sweep_export(what: str, name: str, result: "Sweep") -> Export:
    """A sweep of scene `name`; `what` is `FIGURE` or `DATA`."""

    def draw() -> "Figure":
        from fivtui.sweeps import sweep_figure

        return sweep_figure(result)

    def save(path: Path, force: bool) -> None:
        from fivtui.sweeps import save_sweep

        save_sweep(result, path, force=force)

    of, stem = "the sweep", f"{name}-sweep-{'-'.join(result.study.design.axes)}"
    if what == FIGURE:
        return figure_export(of, stem, draw)
    return data_export(of, stem, "sweep", {".csv": save, ".parquet": save})


def map_export(what: str, name: str, result: "StabilityMap") -> Export:
    """A stability map of scene `name`; `what` is `FIGURE` or `DATA`."""

    def draw() -> "Figure":
        from fivtui.equilibrium import map_figure

        return map_figure(result)

    def save(path: Path, force: bool) -> None:
        from fivtui.equilibrium import save_map

        save_map(result, path, force=force)

    def plain() -> object:
        from fivtui.equilibrium import map_to_dict

        return map_to_dict(result)

    of, stem = "the map", f"{name}-map-{'-'.join(result.names)}"
    if what == FIGURE:
        return figure_export(of, stem, draw)
    writers = {**dict.fromkeys(FORMATS, save), ".json": json_writer(plain)}
    return data_export(of, stem, "map", writers)


def tradeoff_export(what: str, name: str, result: "Tradeoff") -> Export:
    """A trade-off of scene `name`; `what` is `FIGURE` or `DATA`."""

    def draw() -> "Figure":
        from fivtui.tradeoffs import tradeoff_figure

        return tradeoff_figure(result)

    def save(path: Path, force: bool) -> None:
        from fivtui.tradeoffs import save_tradeoff

        save_tradeoff(result, path, force=force)

    def plain() -> object:
        from fivtui.tradeoffs import tradeoff_to_dict

        return tradeoff_to_dict(result)

    of, stem = "the trade-off", f"{name}-tradeoff"
    if what == FIGURE:
        return figure_export(of, stem, draw)
    return data_export(of, stem, "trade-off", {".csv": save, ".json": json_writer(plain)})


def paper_export(what: str, key: str, study: "PaperResults") -> Export:
    """All panels of a figure of the paper, or the data of the panel `key`."""
    digits = key.rstrip("ab")
    number, letter = int(digits), key.removeprefix(digits)

    def draw() -> "Figure":
        from fivtui.paper import draw

        return draw(number, study)

    def save(path: Path, force: bool) -> None:
        from fivtui.paper import save_data

        save_data(study.table(key), path, force=force)

    if what == FIGURE:
        return figure_export(f"Fig. {number}", f"fig-{number:02d}", draw)
    stem = f"fig-{number:02d}{letter}"
    return data_export(f"Fig. {key}", stem, "figure's data", dict.fromkeys(FORMATS, save))


def claims_export(checked: "Sequence[CheckedClaim]") -> Export:
    """The paper's claims with verdicts, as Markdown, CSV or JSON."""

    def plain() -> object:
        from fivtui.paper import claims_to_list

        return claims_to_list(checked)

    def markdown(path: Path, force: bool) -> None:
        from fivtui.io import save_bytes
        from fivtui.paper import claims_markdown

        save_bytes(f"{claims_markdown(checked)}\n".encode(), path, force=force)

    def table(path: Path, force: bool) -> None:
        from fivtui.io import save_bytes
        from fivtui.paper import claims_csv

        save_bytes(claims_csv(checked).encode(), path, force=force)

    writers: dict[str, Save] = {".md": markdown, ".csv": table, ".json": json_writer(plain)}
    return data_export("the claims", "claims", "claims", writers)

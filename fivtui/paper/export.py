"""The paper's figures as files: pictures, with their data as CSV.

A figure has panels, each with a data file. The points of a panel are computed from scenes:
parameter sets with the settings of their runs.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fivtui.charts import FORMATS, save_figure
from fivtui.io import check_distinct, check_output, output_path, publish_together
from fivtui.model import InputError, OnProgress, Progress, check_known, check_names

from .charts import draw
from .data import save_data
from .panels import FIRST_FIGURE, LAST_FIGURE, figure_panels
from .results import PaperResults

NUMBERS: Final = tuple(range(FIRST_FIGURE, LAST_FIGURE + 1))
# A format for print and one for screens.
DEFAULT_FORMATS: Final = ("pdf", "png")
# Share of the progress for the panels of the kind ``amplitude``, if there are any.
_AMPLITUDES_SHARE: Final = 0.6


def figure_numbers(texts: Sequence[str]) -> tuple[int, ...]:
    """Read figure numbers such as ``2`` and ``3-9``, ascending and each once; all if empty.

    Raises `InputError` if one is not a number of a figure that can be computed.
    """
    chosen: set[int] = set()
    for text in texts:
        match = re.fullmatch(r"(\d{1,3})(?:-(\d{1,3}))?", text.strip(), re.ASCII)
        start, end = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
        if not FIRST_FIGURE <= start <= end <= LAST_FIGURE:
            raise InputError(
                f"figure {text!r}: must be {FIRST_FIGURE} to {LAST_FIGURE}, or a range such as "
                f"3-9 (Fig. 1 is the drawing of the model)"
            )
        chosen.update(range(start, end + 1))
    return tuple(sorted(chosen)) or NUMBERS


@dataclass(frozen=True, slots=True)
class FigureFiles:
    """The files of one figure: a picture per format, and a data file per panel."""

    number: int
    pictures: tuple[Path, ...]
    data: tuple[Path, ...]


def figure_files(number: int, folder: Path, formats: Sequence[str]) -> FigureFiles:
    """The files of a figure in a folder: ``fig-02.pdf`` and so on.

    Raises `InputError` if a format is unknown.
    """
    for name in formats:
        check_known("format", name, FORMATS)
    stem = f"fig-{number:02d}"
    panels = figure_panels(number)
    letters = [panel.key.removeprefix(str(number)) for panel in panels]
    return FigureFiles(
        number,
        tuple(folder / f"{stem}.{name}" for name in dict.fromkeys(formats)),
        tuple(folder / f"{stem}{letter}.csv" for letter in letters),
    )


def figures(
    folder: str | Path,
    numbers: Sequence[int] = (),
    *,
    formats: Sequence[str] = DEFAULT_FORMATS,
    force: bool = False,
    progress: OnProgress | None = None,
) -> list[FigureFiles]:
    """Draw the paper's figures into files, each with its data as CSV.

    Parameters
    ----------
    folder : str or Path
        The folder; created if missing.
    numbers : sequence of int
        Numbers of the figures, 2 to 16; all if empty.
    formats : sequence of str
        ``"pdf"``, ``"svg"``, ``"png"``.
    force : bool
        Whether to replace existing files.
    progress : callable, optional
        Called with the fraction done; cancels the work by returning False.

    Returns
    -------
    list of FigureFiles
        The files written, in the order of the figures.

    Raises
    ------
    InputError
        If a number or format is unknown, or a file exists or cannot be written.
    ComputationError
        If a run cannot be finished.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import figures
    >>> (files,) = figures("paper", [2], formats=["png"])
    >>> [path.name for path in files.pictures]
    ['fig-02.png']
    """
    chosen = figure_numbers([str(number) for number in numbers])
    # With `force` the path has a type that permits replacing files; paths in the folder inherit it.
    return save_figures(
        chosen, output_path(folder, force=force), formats=formats, progress=progress
    )


def save_figures(
    numbers: Sequence[int],
    folder: Path,
    *,
    formats: Sequence[str] = DEFAULT_FORMATS,
    results: PaperResults | None = None,
    progress: OnProgress | None = None,
) -> list[FigureFiles]:
    """Compute figures, then write them with their data; parameters and errors as `figures`.

    Data are taken from `results`, which computes those that are missing.
    """
    chosen = figure_numbers([str(number) for number in numbers])
    formats = check_names("formats", formats)
    all_files = [figure_files(number, folder, formats) for number in chosen]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made a folder: {error.strerror}") from None
    paths = [path for files in all_files for path in (*files.pictures, *files.data)]
    check_distinct([("the file", path) for path in paths])
    for path in paths:
        check_output(path)
    work = Progress(progress)
    source = PaperResults() if results is None else results
    panels = [panel for number in chosen for panel in figure_panels(number)]
    amplitudes = [panel for panel in panels if panel.kind == "amplitude"]
    # Compute all amplitudes at once, in parallel, then the other panels one by one.
    share = _AMPLITUDES_SHARE if amplitudes else 0.0
    source.prepare(
        (scene for panel in amplitudes for scene in panel.scenes()),
        work.stage(0.0, share).callback,
    )
    for panel in panels:
        # `source` keeps the table. `report` lets the caller cancel; the progress stays the same.
        source.table(panel.key)
        work.report(share)
    for count, files in enumerate(all_files, start=1):
        figure = draw(files.number, source)
        # All files of a figure appear at once, or none if one cannot be written.
        with publish_together():
            for path in files.pictures:
                save_figure(figure, path)
            for panel, path in zip(figure_panels(files.number), files.data, strict=True):
                save_data(source.table(panel.key), path)
        work.report(share + (1.0 - share) * count / len(all_files))
    # Plain paths, which no longer allow files to be replaced.
    return [figure_files(number, Path(folder), formats) for number in chosen]

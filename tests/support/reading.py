"""Reads figures: legend entries, and the lines that match them."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.charts.sheet import sheet_figure
from fivtui.transient.charts import transient_sheet
from fivtui.transient.result import Transient

FloatArray = NDArray[np.float64]


def without_mathtext(text: str) -> str:
    """A label without the marks of mathtext, and with spaces in place of line breaks."""
    text = re.sub(r"_\{\\mathrm\{(\w+)\}\}", r"_\1", text.replace("\N{NO-BREAK SPACE}", " "))
    return text.replace("$", "").replace("\n", " ")


def line_style(line: Line2D) -> tuple[Any, ...]:
    """Visual properties that identify a line."""
    dashes = line._unscaled_dash_pattern  # type: ignore[attr-defined]
    return line.get_color(), str(dashes), line.get_marker(), line.get_linestyle()


def handles_by_text(legend: Legend) -> dict[str, Any]:
    """Handles of a legend by their texts."""
    texts = [without_mathtext(text.get_text()) for text in legend.get_texts()]
    assert len(set(texts)) == len(texts)
    return dict(zip(texts, legend.legend_handles, strict=True))


def legend_entries(figure: Figure) -> dict[str, Any]:
    """Handles of the figure's only legend by their texts."""
    (legend,) = figure.legends
    return handles_by_text(legend)


def drawn_lines(axes: Axes, entry: Line2D) -> list[Line2D]:
    """Lines that look like a legend's entry."""
    return [line for line in axes.get_lines() if line_style(line) == line_style(entry)]


def drawn_line(axes: Axes, entry: Line2D) -> Line2D:
    """The only line that looks like a legend's entry."""
    (line,) = drawn_lines(axes, entry)
    return line


def points(line: Line2D) -> tuple[FloatArray, FloatArray]:
    """Coordinates of a line."""
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def spans(axes: Axes) -> list[tuple[float, float]]:
    """Shaded intervals along x."""
    shaded = [
        collection for collection in axes.collections if isinstance(collection, PolyCollection)
    ]
    boxes = [path.get_extents() for collection in shaded for path in collection.get_paths()]
    assert all((box.y0, box.y1) == (0.0, 1.0) for box in boxes)
    return [(float(box.x0), float(box.x1)) for box in boxes]


def labels(axes: Axes) -> tuple[str, str]:
    """Labels of the axes."""
    return without_mathtext(axes.get_xlabel()), without_mathtext(axes.get_ylabel())


def transient_figure(
    runs: Sequence[Transient], quantities: Sequence[str] = ("P", "x", "y"), title: str = ""
) -> Figure:
    """Figure of quantities over time for some runs; a sheet is its layout before it is drawn."""
    return sheet_figure(transient_sheet(runs, quantities, title))

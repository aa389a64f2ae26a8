"""Style and files of all figures, which are drawn by matplotlib without pyplot."""

import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from fivtui.io import check_output, check_suffix, write_atomically
from fivtui.version import __version__

from .colours import figure_colour

# Metadata by suffix, without date: the same figure always gives the same bytes.
_METADATA: Final[Mapping[str, Mapping[str, str | None]]] = {
    ".png": {"Software": f"fivtui {__version__}"},
    ".svg": {"Creator": f"fivtui {__version__}", "Date": None},
    ".pdf": {"Creator": f"fivtui {__version__}", "CreationDate": None},
}
FORMATS: Final = tuple(suffix.removeprefix(".") for suffix in _METADATA)
# Font type 42 keeps the text of a PDF searchable.
_SAVE_OPTIONS: Final[dict[Any, Any]] = {"svg.hashsalt": "fivtui", "pdf.fonttype": 42}
_DPI: Final = 200
_NOTEBOOK_DPI: Final = 110
# Matplotlib's settings while a figure is drawn.
STYLE: Final[dict[Any, Any]] = {
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "figure.titlesize": 10.0,
    "legend.fontsize": 8.5,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.5,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "hatch.linewidth": 0.3,
}
# Background colours of intervals of separation and of stick.
OFF_BELT_COLOUR: Final = "0.9"
STUCK_COLOUR: Final = figure_colour("series-2", 0.25)
_SETTINGS_LOCK: Final = threading.RLock()


@contextmanager
def drawing_settings(settings: dict[Any, Any]) -> Iterator[None]:
    """Change matplotlib's settings; they hold for all threads, so one thread draws at a time."""
    with _SETTINGS_LOCK, mpl.rc_context(settings):
        yield


class NotebookFigure(Figure):
    """A figure that a notebook displays without pyplot and without a magic command."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        self.savefig(buffer, format="png", dpi=_NOTEBOOK_DPI)
        return buffer.getvalue()


def new_figure(width: float, height: float, *, wspace: float | None = None) -> Figure:
    """An empty figure in inches, with an Agg canvas; `wspace` is the gap between panels."""
    figure = NotebookFigure(figsize=(width, height), layout=ConstrainedLayoutEngine(wspace=wspace))
    FigureCanvasAgg(figure)
    return figure


def shade_times(
    axes: Axes, intervals: Sequence[tuple[float, float]], colour: str, label: str = ""
) -> None:
    """Shade intervals of time, s, over the height of a panel; `intervals` may be empty."""
    if intervals:
        axes.broken_barh(
            [(start, end - start) for start, end in intervals],
            (0.0, 1.0),
            transform=axes.get_xaxis_transform(),
            facecolor=colour,
            linewidth=0.0,
            zorder=0.0,
            label=label or "_",
        )


def check_figure_path(path: Path) -> None:
    """Raise `InputError` if a figure cannot be written to this path."""
    check_suffix(path, "figure", _METADATA)
    check_output(path)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure to a file; the same figure always gives the same bytes."""
    suffix = check_suffix(path, "figure", _METADATA)

    def write(file: BinaryIO) -> None:
        # Draw into memory: matplotlib hides the cause if a file cannot be written.
        content = BytesIO()
        with drawing_settings(_SAVE_OPTIONS):
            figure.savefig(
                content, format=suffix.removeprefix("."), dpi=_DPI, metadata=dict(_METADATA[suffix])
            )
        file.write(content.getbuffer())

    write_atomically(path, write)

"""Results as publishable figures, without pyplot."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from . import __version__
from .core.errors import InputError
from .core.parameters import PARAMETERS
from .core.trajectory import COLUMNS, Trajectory
from .core.transient import Transient
from .files import check_output, check_suffix, write_atomically
from .results import trajectory_of

# Metadata by suffix: no date, so that the same figure always gives the same bytes.
_METADATA: Final[Mapping[str, Mapping[str, str | None]]] = {
    ".png": {"Software": f"fivtui {__version__}"},
    ".svg": {"Creator": f"fivtui {__version__}", "Date": None},
    ".pdf": {"Creator": f"fivtui {__version__}", "CreationDate": None},
}
_SAVING: Final[dict[Any, Any]] = {
    "svg.hashsalt": "fivtui",
    "pdf.fonttype": 42,
    "agg.path.chunksize": 20_000,
}
_DPI: Final = 200


_PANELS: Final = ("P", "x", "y")
# Runs with separation considered and ignored differ in their lines, several of a kind in markers.
_LINES: Final[Mapping[bool, str]] = {True: "--", False: "-"}
_COLOURS: Final[Mapping[bool, Sequence[str]]] = {
    True: ("#12803c", "#8a8a00", "#00867d", "#4f5d1e"),
    False: ("#1f4fd8", "#7a3fc4", "#0083b8", "#1b2a6b"),
}
_MARKERS: Final = ("", "o", "s", "^", "D", "v")
_SHADE: Final = "0.88"
_SIZE: Final = (7.2, 6.4)
_STYLE: Final[dict[Any, Any]] = {
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.5,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.5,
    "xtick.direction": "in",
    "ytick.direction": "in",
}
# Enlarged are about this many last cycles, if the whole time has more than twice as many.
_CYCLES: Final = 8


def transient_figure(runs: Sequence[Transient], *, title: str | None = None) -> Figure:
    """Contact force, horizontal and vertical displacement over time (the paper's Figs. 10 to 12).

    Beside the whole time stand the last cycles, enlarged. Separation ignored is drawn solid blue,
    considered dashed green. The times off the belt are shaded where they are those of one run.

    Parameters
    ----------
    runs : sequence of Transient
        One or several results computed with sample times.
    title : str, optional
        Title above the panels.

    Returns
    -------
    Figure
        With an Agg canvas; it belongs to no window.

    Raises
    ------
    InputError
        If there is no run, or one without trajectory.
    ComputationError
        If a sample is not finite.
    """
    if not runs:
        raise InputError("figure: allowed are one or more runs")
    trajectories = [trajectory_of(run) for run in runs]
    windows = _windows(runs, trajectories)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=_SIZE, layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(
            len(_PANELS), len(windows), sharex="col", sharey="row", squeeze=False
        )
        for row, name in zip(panels, _PANELS, strict=True):
            for axes, window in zip(row, windows, strict=True):
                _draw_panel(axes, runs, trajectories, name, window)
            row[0].set_ylabel(_axis_label(name))
        for axes in panels[-1]:
            axes.set_xlabel(_axis_label("t"))
        figure.align_ylabels()
        handles, labels = panels[0, -1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False)
        if title is not None:
            figure.suptitle(title)
    return figure


def run_labels(runs: Sequence[Transient]) -> list[str]:
    """What tells runs apart, for legends.

    Parameters
    ----------
    runs : sequence of Transient
        The runs.

    Returns
    -------
    list of str
        A label a run, each different, in matplotlib's mathtext: whether separation is considered,
        then the parameters, method and start in which the runs differ.
    """
    varied = [n for n in PARAMETERS if len({getattr(run.parameters, n) for run in runs}) > 1]
    several = len({run.method for run in runs}) > 1
    labels = []
    for run in runs:
        parts = ["separation considered" if run.separation else "separation ignored"]
        parts += [_value_label(name, getattr(run.parameters, name)) for name in varied]
        labels.append(", ".join([*parts, run.method] if several else parts))
    starts = [f"start ({', '.join(f'{value:.3g}' for value in run.start)})" for run in runs]
    labels = _told_apart(labels, starts)
    return _told_apart(labels, [f"run {number}" for number in range(1, len(runs) + 1)])


def _told_apart(labels: Sequence[str], additions: Sequence[str]) -> list[str]:
    # Adds to those labels that are not alone in their name, where the addition says anything.
    pairs = list(zip(labels, additions, strict=True))
    varied = {label for label in labels if len({more for same, more in pairs if same == label}) > 1}
    return [f"{label}, {more}" if label in varied else label for label, more in pairs]


def _value_label(name: str, value: float) -> str:
    spec = PARAMETERS[name]
    return f"{_math(spec.symbol)} = {value:g} {_unit(spec.unit)}".rstrip()


def _axis_label(name: str) -> str:
    column = next(column for column in COLUMNS if column.name == name)
    return f"{column.meaning.capitalize()} {_math(name)} ({_unit(column.unit)})"


def _math(symbol: str) -> str:
    head, _, index = symbol.partition("_")
    return f"${head}_{{\\mathrm{{{index}}}}}$" if index else f"${head}$"


def _unit(unit: str) -> str:
    base, _, power = unit.partition("^")
    return f"{base}$^{power}$" if power else base


def _windows(
    runs: Sequence[Transient], trajectories: Sequence[Trajectory]
) -> list[tuple[float, float]]:
    # The whole time and, if it has many cycles, the last of them.
    longest = max(range(len(runs)), key=lambda index: runs[index].t_end)
    t_end, trajectory = runs[longest].t_end, trajectories[longest]
    late = trajectory.t >= 0.5 * t_end
    t, y = trajectory.t[late], trajectory.y[late]
    rising = np.flatnonzero(np.diff(np.sign(y - y.mean())) > 0) if t.size else t
    whole = (0.0, t_end)
    if rising.size <= _CYCLES:
        return [whole]
    length = _CYCLES * float(t[rising[-1]] - t[rising[0]]) / (rising.size - 1)
    unit = 10.0 ** math.floor(math.log10(length))
    length = unit * min((1.0, 2.0, 5.0, 10.0), key=lambda digit: abs(digit * unit - length))
    return [whole, (t_end - length, t_end)]


def _draw_panel(
    axes: Axes,
    runs: Sequence[Transient],
    trajectories: Sequence[Trajectory],
    name: str,
    window: tuple[float, float],
) -> None:
    left, right = window
    zoomed = left > 0.0
    considered = [run for run in runs if run.separation]
    if len(considered) == 1:
        spans = [(start, end - start) for start, end in considered[0].separated_intervals]
        axes.broken_barh(
            spans,
            (0.0, 1.0),
            transform=axes.get_xaxis_transform(),
            facecolor=_SHADE,
            linewidth=0.0,
            zorder=0.0,
            label="off the belt",
        )
    axes.axhline(0.0, color="0.4", linewidth=0.5, zorder=1.0)
    seen = {True: 0, False: 0}
    for run, trajectory, label in zip(runs, trajectories, run_labels(runs), strict=True):
        number = seen[run.separation]
        seen[run.separation] += 1
        inside = slice(
            max(int(np.searchsorted(trajectory.t, left)) - 1, 0),
            int(np.searchsorted(trajectory.t, right, side="right")) + 1,
        )
        colours = _COLOURS[run.separation]
        axes.plot(
            trajectory.t[inside],
            getattr(trajectory, name)[inside],
            linestyle=_LINES[run.separation],
            color=colours[number % len(colours)],
            marker=_MARKERS[number % len(_MARKERS)],
            markevery=0.13,
            markersize=3.5,
            linewidth=1.1 if zoomed else 0.6,
            label=label,
        )
    axes.set_xlim(left, right)


def check_figure_path(path: Path, *, force: bool) -> None:
    """Check that a figure can be written to a file, before it is made.

    Parameters
    ----------
    path : Path
        The file; its suffix says the format.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the format is unknown, or as `check_output`.
    """
    check_suffix(path, "figure", _METADATA)
    check_output(path, force=force)


def save_figure(figure: Figure, path: Path, *, force: bool = False) -> None:
    """Write a figure; the same figure always gives the same bytes.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : Path
        The file; its suffix ``.png`` (200 dpi), ``.svg`` or ``.pdf`` says the format.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If the format is unknown or the file cannot be written.
    """
    suffix = check_suffix(path, "figure", _METADATA)

    def write(file: BinaryIO) -> None:
        with mpl.rc_context(_SAVING):
            figure.savefig(
                file, format=suffix.removeprefix("."), dpi=_DPI, metadata=dict(_METADATA[suffix])
            )

    write_atomically(path, write, force=force)

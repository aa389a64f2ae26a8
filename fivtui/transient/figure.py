"""Transients as publishable figures."""

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fivtui.charts import (
    CASE_COLOURS,
    CASE_LINES,
    OFF_BELT,
    STUCK,
    STYLE,
    WIDTH,
    math_symbol,
    math_unit,
    new_figure,
    shade_times,
    value_label,
)
from fivtui.model import ALL_PARAMETERS, InputError, unknown_name

from .files import trajectory_of
from .result import Transient
from .trajectory import COLUMNS, Trajectory

_PANELS: Final = ("P", "x", "y")
# Several runs of one case differ by their markers.
_MARKERS: Final = ("", "o", "s", "^", "D", "v")
# Motion smaller than this, relative to the displacement, is rest.
_ROUNDING: Final = 1e-9
# Widths of lines, points.
_WIDE: Final = 1.1
_NARROW: Final = 0.6
# Inches: height of a row of panels, of an only row, and of what stands above and below.
_ROW: Final = 1.85
_ONLY_ROW: Final = 2.3
_MARGIN: Final = 0.85
# Number of last cycles enlarged, about, of a run that has more than twice as many.
_CYCLES: Final = 8
# Beyond this many cycles dashes and shading are too fine to be seen.
_CROWDED: Final = 120
# Groups of samples that a line is reduced to: several a pixel.
_GROUPS: Final = 4000
# Markers a line.
_MARKS: Final = 12
# Characters of mathtext that fit beside each other in the legend, and its line spacing, inches.
_LEGEND_WIDTH: Final = 100
_LEGEND_LINE: Final = 0.18


def transient_figure(
    runs: Sequence[Transient], *, title: str | None = None, quantities: Sequence[str] = _PANELS
) -> Figure:
    """Contact force, horizontal and vertical displacement over time (the paper's Figs. 10 to 12).

    Beside the whole time stand the last cycles, enlarged. Separation ignored is drawn solid blue,
    considered dashed green. The times off the belt are shaded where they are those of one run, and
    those at which the only run sticks to a belt of finite speed.
    """
    if not runs:
        raise InputError("figure: there is no run to draw")
    known = [column.name for column in COLUMNS]
    for name in quantities:
        if name not in known:
            raise unknown_name("quantity", name, known)
    curves = _curves(runs)
    windows = _windows(max(curves, key=lambda curve: curve.run.t_end))
    considered = [run for run in runs if run.separation]
    off = considered[0].separated_intervals if len(considered) == 1 else []
    held = runs[0].stick_intervals if len(runs) == 1 else []
    with mpl.rc_context(STYLE):
        height = max(_ROW * len(quantities), _ONLY_ROW) + _MARGIN
        figure = new_figure(WIDTH, height, wspace=0.05)
        panels = figure.subplots(
            len(quantities), len(windows), sharex="col", sharey="row", squeeze=False
        )
        for row, name in zip(panels, quantities, strict=True):
            for axes, window in zip(row, windows, strict=True):
                _draw_panel(axes, curves, name, window)
                if not window.crowded:
                    shade_times(axes, off, OFF_BELT, "off the belt")
                    shade_times(axes, held, STUCK, "stuck to the belt")
            row[0].set_ylabel(_axis_label(name).replace(" ", "\n", 1))
        for axes, window in zip(panels[0], windows, strict=True):
            axes.set_title(window.title)
        for axes in panels[-1]:
            axes.set_xlabel(_axis_label("t"))
        figure.align_ylabels()
        _add_legend(figure, panels[0, -1])
        if title is not None:
            figure.suptitle(title, parse_math=False)
    return figure


def run_labels(runs: Sequence[Transient]) -> list[str]:
    """Legend labels of runs, each different, in matplotlib's mathtext.

    Whether separation is considered, then the parameters, method and start in which the runs
    differ.
    """
    varied = [n for n in ALL_PARAMETERS if len({getattr(run.parameters, n) for run in runs}) > 1]
    several = len({run.method for run in runs}) > 1
    labels = []
    for run in runs:
        parts = ["separation considered" if run.separation else "separation ignored"]
        parts += [value_label(name, getattr(run.parameters, name)) for name in varied]
        labels.append(", ".join([*parts, run.method] if several else parts))
    starts = [f"start ({', '.join(f'{value:.3g}' for value in run.start)})" for run in runs]
    starts = [start.replace("-", "−") for start in starts]
    labels = _told_apart(labels, starts)
    return _told_apart(labels, [f"run {number}" for number in range(1, len(runs) + 1)])


def _told_apart(labels: Sequence[str], additions: Sequence[str]) -> list[str]:
    # Adds to labels that occur more than once, where the additions differ.
    pairs = list(zip(labels, additions, strict=True))
    varied = {label for label in labels if len({more for same, more in pairs if same == label}) > 1}
    return [f"{label}, {more}" if label in varied else label for label, more in pairs]


def _axis_label(name: str) -> str:
    column = next(column for column in COLUMNS if column.name == name)
    return f"{column.meaning.capitalize()} {math_symbol(name)} ({math_unit(column.unit)})"


@dataclass(frozen=True, slots=True)
class _Curve:
    # A run and how it is drawn.
    run: Transient
    trajectory: Trajectory
    label: str
    colour: str
    marker: str
    phase: float


def _curves(runs: Sequence[Transient]) -> list[_Curve]:
    seen = {True: 0, False: 0}
    curves = []
    for number, (run, label) in enumerate(zip(runs, run_labels(runs), strict=True)):
        same, colours = seen[run.separation], CASE_COLOURS[run.separation]
        seen[run.separation] += 1
        curves.append(
            _Curve(
                run=run,
                trajectory=trajectory_of(run),
                label=label,
                colour=colours[same % len(colours)],
                marker=_MARKERS[same % len(_MARKERS)],
                phase=number / len(runs),
            )
        )
    return curves


@dataclass(frozen=True, slots=True)
class _Window:
    # A column of panels: its times in s, the width of its lines in points, and whether cycles are
    # too narrow for dashes.
    title: str
    left: float
    right: float
    width: float
    crowded: bool = False


def _windows(curve: _Curve) -> list[_Window]:
    # The whole time and, if it has many cycles, the last of them.
    t_end, period = curve.run.t_end, _period(curve.trajectory)
    if period is None or t_end < 2 * _CYCLES * period:
        return [_Window("", 0.0, t_end, _WIDE)]
    length = _round_number(_CYCLES * period)
    return [
        _Window("whole run", 0.0, t_end, _NARROW, crowded=t_end > _CROWDED * period),
        _Window(f"last {length:g} s", t_end - length, t_end, _WIDE),
    ]


def _period(trajectory: Trajectory) -> float | None:
    # Mean time between upward crossings of the mean vertical displacement, late in the run.
    late = trajectory.t >= 0.5 * trajectory.t[-1]
    t, y = trajectory.t[late], trajectory.y[late]
    rising = t[:-1][np.diff(np.sign(y - y.mean())) > 0]
    if np.ptp(y) <= _ROUNDING * np.abs(y).max():
        return None
    return float(rising[-1] - rising[0]) / (rising.size - 1) if rising.size > 1 else None


def _round_number(value: float) -> float:
    unit = 10.0 ** math.floor(math.log10(value))
    return unit * min((1.0, 2.0, 5.0, 10.0), key=lambda digit: abs(digit * unit - value))


def _draw_panel(axes: Axes, curves: Sequence[_Curve], name: str, window: _Window) -> None:
    axes.axhline(0.0, color="0.4", linewidth=0.5, zorder=1.0)
    if name == "vx":
        for speed in set(filter(None, (_constant_speed(curve.run) for curve in curves))):
            axes.axhline(speed, color="0.4", linewidth=0.5, linestyle=":", zorder=1.0)
    for curve in curves:
        t, values = _reduced(curve.trajectory, name, window)
        every = max(t.size // _MARKS, 1)
        axes.plot(
            t,
            values,
            linestyle="-" if window.crowded else CASE_LINES[curve.run.separation],
            color=curve.colour,
            marker=curve.marker,
            markevery=(int(curve.phase * every), every),
            markersize=3.5,
            linewidth=window.width,
            zorder=2.5 if curve.run.separation else 2.0,
            label=curve.label,
        )
    axes.set_xlim(window.left, window.right)


def _constant_speed(run: Transient) -> float | None:
    # Of the belt, m/s, on which a slider that sticks stays.
    return None if "v_belt" in run.over_time else run.parameters.v_belt


def _reduced(
    trajectory: Trajectory, name: str, window: _Window
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # The samples in a window; of many, the least and greatest of each group in order of time.
    first, last = np.searchsorted(trajectory.t, [window.left, window.right])
    inside = slice(max(int(first) - 1, 0), int(last) + 1)
    t, values = trajectory.t[inside], getattr(trajectory, name)[inside]
    size = t.size // _GROUPS
    if size <= 2:
        return t, values
    groups = values[: size * _GROUPS].reshape(_GROUPS, size)
    starts = size * np.arange(_GROUPS)
    kept = np.concatenate(
        [[0], starts + groups.argmin(axis=1), starts + groups.argmax(axis=1)],
    )
    kept = np.union1d(kept, np.arange(size * _GROUPS, t.size))
    return t[kept], values[kept]


def _add_legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    # Lines first, shading last.
    order = sorted(range(len(labels)), key=lambda index: not isinstance(handles[index], Line2D))
    columns = max(1, min(3, _LEGEND_WIDTH // (max(map(len, labels)) + 8)))
    wrapped = [
        textwrap.fill(label, _LEGEND_WIDTH, break_on_hyphens=False, break_long_words=False)
        for label in labels
    ]
    lines = math.ceil(sum(label.count("\n") + 1 for label in wrapped) / columns)
    figure.set_figheight(figure.get_figheight() + _LEGEND_LINE * (lines - 1))
    figure.legend(
        [handles[index] for index in order],
        [wrapped[index] for index in order],
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        handlelength=3.0,
    )

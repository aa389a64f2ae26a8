"""Figures of results: the charts that a study declares, drawn by matplotlib."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .chart import Chart, Guide, Sheet
from .labels import Label
from .plotting import OFF_BELT, STUCK, STYLE, new_figure, shade_times

_TITLE_SIZE: Final = 7.5
_PANEL_GAP: Final = 0.06
# Markers and dashes distinguish the series of a chart in black and white, too.
_SERIES: Final[tuple[Mapping[str, Any], ...]] = (
    {"color": "#12803c", "marker": "o", "linestyle": "-"},
    {"color": "#00867d", "marker": "s", "linestyle": "--"},
    {"color": "#1f4fd8", "marker": "^", "linestyle": "-"},
    {"color": "#7a3fc4", "marker": "v", "linestyle": "--"},
    {"color": "#c8252c", "marker": "D", "linestyle": "-"},
    {"color": "#b07d00", "marker": "x", "linestyle": "-"},
    {"color": "0.35", "marker": "+", "linestyle": "--"},
    {"color": "black", "marker": "*", "linestyle": ":"},
    {"color": "#c2378f", "marker": "P", "linestyle": ":"},
)
# What traces and guides are, and how figures draw them.
ROLES: Final[Mapping[str, Mapping[str, Any]]] = {
    "front": {"color": "0.8", "linewidth": 4.0, "zorder": 1.0},
    "mode 1": {"color": "#1f4fd8", "linestyle": "-", "linewidth": 1.4},
    "mode 2": {"color": "#b07d00", "linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.4},
    "path": {"color": "0.6", "linestyle": "none", "marker": ".", "markersize": 2.0},
    "present point": {
        "color": "black",
        "linestyle": "none",
        "marker": "D",
        "markersize": 4.5,
        "markerfacecolor": "white",
    },
    "stable": {"color": "#12803c", "linestyle": "-"},
    "unstable": {"color": "#1f4fd8", "linestyle": "--"},
    "event": {
        "color": "black",
        "linestyle": "none",
        "markersize": 5.0,
        "markerfacecolor": "white",
    },
    "chosen cycle": {"marker": ".", "markersize": 4.0, "zorder": 3.0},
    "stable orbit": {"linestyle": "-", "linewidth": 0.9},
    "unstable orbit": {"linestyle": "--", "linewidth": 0.9},
    "unit circle": {"color": "0.6", "linewidth": 0.6},
    "stable multipliers": {
        "color": "#12803c",
        "linestyle": "none",
        "marker": ".",
        "markersize": 2.0,
    },
    "unstable multipliers": {
        "color": "#1f4fd8",
        "linestyle": "none",
        "marker": ".",
        "markersize": 2.0,
    },
    "critical": {"color": "#c8252c", "linestyle": ":", "linewidth": 1.0, "zorder": 1.5},
    "present": {"color": "0.35", "linestyle": "-.", "linewidth": 0.8, "zorder": 1.4},
}
_ZERO: Final[Mapping[str, Any]] = {"color": "0.4", "linewidth": 0.5, "zorder": 1.0}
# Shades of strips, from the first.
_STRIPS: Final = (OFF_BELT, STUCK)


def sheet_figure(sheet: Sheet) -> Figure:
    """Draw the charts of a sheet; the figure has an Agg canvas.

    Charts over the same quantity share their x axis.
    """
    with mpl.rc_context(STYLE):
        gap = _PANEL_GAP if len(sheet.columns) > 2 else None
        figure = new_figure(*sheet.size, wspace=gap)
        grid = figure.add_gridspec(1, len(sheet.columns), width_ratios=sheet.widths or None)
        panels = []
        first_over: dict[str, Axes] = {}
        for column, charts in enumerate(sheet.columns):
            rows = grid[0, column].subgridspec(len(charts), 1, height_ratios=sheet.heights or None)
            for row, chart in enumerate(charts):
                axes = figure.add_subplot(rows[row, 0], sharex=first_over.get(chart.x_label))
                first_over.setdefault(chart.x_label, axes)
                _draw_chart(axes, chart)
                panels.append((axes, chart))
        _add_title(figure, [axes for axes, _ in panels], sheet.title)
        below = [axes for axes, chart in panels if chart.legend == "below"]
        _add_legend(figure, below, sheet.legend_columns)
    return figure


def _add_title(figure: Figure, panels: Sequence[Axes], title: str) -> None:
    if title and len(panels) > 1:
        figure.suptitle(title, fontsize=_TITLE_SIZE)
    elif title:
        panels[0].set_title(title, fontsize=_TITLE_SIZE)


def _add_legend(figure: Figure, panels: Sequence[Axes], columns: int) -> None:
    # Each name once.
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if handles:
        figure.legend(
            list(handles.values()),
            list(handles),
            loc="outside lower center",
            ncols=columns,
            frameon=False,
            handlelength=3.0,
        )


def _draw_chart(axes: Axes, chart: Chart) -> None:
    series = 0
    for trace in chart.traces:
        # A trace without points has no name in the legend.
        if not trace.x.size:
            continue
        look = dict(ROLES.get(trace.role, {}))
        if trace.role == "series":
            look = {"markersize": 4.5, "linewidth": 0.9, **_SERIES[series % len(_SERIES)]}
            series += 1
        if trace.colour:
            look["color"] = trace.colour
        if trace.marker:
            look["marker"] = trace.marker
        axes.plot(trace.x, trace.y, label=_math(trace.name) or "_", **look)
    for number, strip in enumerate(chart.strips):
        shade_times(axes, strip.intervals, _STRIPS[number % len(_STRIPS)], strip.meaning)
    _scale(axes, chart)
    for guide in chart.guides:
        _draw_guide(axes, guide)
    axes.set_xlabel(_math(chart.x_label))
    axes.set_ylabel(_math(chart.y_label))
    if chart.legend == "above":
        axes.legend(
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=2,
            fontsize=6.0,
            frameon=False,
            handlelength=1.5,
        )
    elif chart.legend == "inside":
        axes.legend(frameon=False, fontsize=8.0)


def _scale(axes: Axes, chart: Chart) -> None:
    if "x" in chart.log:
        axes.set_xscale("log")
    if "y" in chart.log:
        axes.set_yscale("log")
    if chart.tight and not chart.plane and chart.traces:
        axes.set_xlim(chart.traces[0].x[0], chart.traces[0].x[-1])
    if chart.linear_within:
        axes.set_xscale("symlog", linthresh=chart.linear_within)
    elif chart.to_scale:
        axes.set_aspect("equal", adjustable="datalim")
    if any(limit is not None for limit in chart.figure_x):
        axes.set_xlim(*chart.figure_x)
    if any(limit is not None for limit in chart.figure_y):
        axes.set_ylim(*chart.figure_y)


def _draw_guide(axes: Axes, guide: Guide) -> None:
    if guide.role == "floor":
        axes.axhspan(axes.get_ylim()[0], guide.value, color="0.93", zorder=0.0)
        return
    line = axes.axvline if guide.vertical else axes.axhline
    look = ROLES.get(guide.role)
    # Lines without a role have no name in the legend.
    if look is None:
        line(guide.value, label="_", **_ZERO)
    else:
        line(guide.value, label=_math(guide.label), **look)


def _math(label: str) -> str:
    return label.math if isinstance(label, Label) else label.replace("$", r"\$")

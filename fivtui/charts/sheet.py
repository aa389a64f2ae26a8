"""Figures of results: the charts that a study declares, drawn by matplotlib."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .chart import Chart, Guide, Sheet, Trace
from .labels import Label
from .plotting import STYLE, new_figure

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
}


def sheet_figure(sheet: Sheet) -> Figure:
    """Draw the charts of a sheet, with one legend below; the figure has an Agg canvas."""
    with mpl.rc_context(STYLE):
        figure = new_figure(*sheet.size, wspace=_PANEL_GAP if len(sheet.panels) > 1 else None)
        panels = list(figure.subplots(1, len(sheet.panels), squeeze=False)[0])
        for axes, chart in zip(panels, sheet.panels, strict=True):
            _draw_chart(axes, chart)
        _add_title(figure, panels, sheet.title)
        _add_legend(figure, panels, sheet.legend_columns)
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
        )


def _draw_chart(axes: Axes, chart: Chart) -> None:
    series = 0
    for trace in chart.traces:
        look = dict(ROLES.get(trace.role, {}))
        if trace.role == "series":
            look = {"markersize": 4.5, "linewidth": 0.9, **_SERIES[series % len(_SERIES)]}
            series += 1
        _draw_trace(axes, trace, look)
    if "x" in chart.log:
        axes.set_xscale("log")
    if "y" in chart.log:
        axes.set_yscale("log")
    axes.set_xlim(*chart.figure_x)
    axes.set_ylim(*chart.figure_y)
    for guide in chart.guides:
        _draw_guide(axes, guide)
    axes.set_xlabel(_math(chart.x_label))
    axes.set_ylabel(_math(chart.y_label))


def _draw_trace(axes: Axes, trace: Trace, look: dict[str, Any]) -> None:
    if trace.marker:
        look["marker"] = trace.marker
    axes.plot(trace.x, trace.y, label=_math(trace.name) or "_", **look)


def _draw_guide(axes: Axes, guide: Guide) -> None:
    if guide.role == "floor":
        axes.axhspan(axes.get_ylim()[0], guide.value, color="0.93", zorder=0.0)


def _math(label: str) -> str:
    return label.math if isinstance(label, Label) else label.replace("$", r"\$")

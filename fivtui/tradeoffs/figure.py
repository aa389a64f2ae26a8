"""Figure of a trade-off: error against CPU time."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure

from fivtui.charts import STYLE, WIDTH, new_figure

from .files import fronts
from .measure import Tradeoff
from .settings import MeasuredSetting

_HEIGHT: Final = 3.9
_PANELS: Final = {
    "final": "Error of the final state (1)",
    "peak": "Error of the peak of $|y|$ (1)",
    "events": "Error of the switch times (s)",
}
# Markers and dashes distinguish the methods in black and white, too.
_LOOKS: Final[Sequence[Mapping[str, Any]]] = (
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
# An error of zero is drawn here.
_LEAST: Final = 1e-16


def tradeoff_figure(result: Tradeoff) -> Figure:
    """Error against CPU time: final state, peak and switch times, a line for each method.

    Shaded are errors below the uncertainty of the reference; the grey line joins the settings that
    no other beats. The figure has an Agg canvas.
    """
    by_method: dict[str, list[MeasuredSetting]] = {}
    for row in result.rows:
        if row.error is not None:
            by_method.setdefault(row.setting.label, []).append(row)
    best = fronts(result)
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, _HEIGHT, wspace=0.06)
        panels = figure.subplots(1, len(_PANELS), sharex=True)
        for axes, (name, label) in zip(panels, _PANELS.items(), strict=True):
            axes.plot(*_points(best[name], name), color="0.8", linewidth=4.0, zorder=1.0)
            for look, (method, rows) in zip(_LOOKS, by_method.items(), strict=False):
                axes.plot(*_points(rows, name), label=method, markersize=4.5, linewidth=0.9, **look)
            axes.axhspan(0.1 * _LEAST, max(result.floor.of(name), _LEAST), color="0.93", zorder=0.0)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_ylim(bottom=0.3 * _LEAST)
            axes.set_ylabel(label)
            axes.set_xlabel("CPU time of a run (s)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _points(rows: Sequence[MeasuredSetting], name: str) -> tuple[list[float], list[float]]:
    found = [(row.cpu_s, row.error.of(name)) for row in rows if row.error is not None]
    finite = [(cpu_s, max(error, _LEAST)) for cpu_s, error in found if error < float("inf")]
    return [cpu_s for cpu_s, _ in finite], [error for _, error in finite]

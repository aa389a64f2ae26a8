"""Figures of curves over two parameters."""

from typing import Final

import matplotlib as mpl
from matplotlib.figure import Figure

from fivtui.charts import STYLE, new_figure, parameter_line, quantity_label
from fivtui.model import PARAMETERS
from fivtui.orbits.curves.events import EventKind

from .result import Boundary

_SIZE: Final = (4.8, 3.9)
_COLOURS: Final = {"hopf": "black", "fold": "#c0392b", "touch": "#1f4fd8"}
_EVENT_MARKERS: Final = {
    EventKind.CUSP: "D",
    EventKind.BAUTIN: "o",
    EventKind.TOUCH: "s",
    EventKind.FOLD: "^",
}
_SAID: Final = {"hopf": "Hopf points", "fold": "folds", "touch": "first touch of $y$ = 0"}
_COMMON_NAMES: Final = {EventKind.BAUTIN: "Bautin"}


def boundary_figure(result: Boundary) -> Figure:
    """Figure of the curves in the plane of the two parameters, events marked.

    Agg canvas, no window.
    """
    with mpl.rc_context(STYLE):
        figure = new_figure(*_SIZE)
        axes = figure.subplots()
        for place, curve in enumerate(result.curves):
            axes.plot(
                *zip(*(point.values for point in curve.points), strict=True),
                color=_COLOURS[result.kind],
                label=_SAID[result.kind] if place == 0 else None,
            )
        for kind, marker in _EVENT_MARKERS.items():
            found = [event.values for event in result.events if event.kind is kind]
            if found:
                axes.plot(
                    *zip(*found, strict=True),
                    linestyle="none",
                    marker=marker,
                    markersize=5.0,
                    markerfacecolor="white",
                    color="black",
                    label=_COMMON_NAMES.get(kind, str(kind)),
                )
        first, second = (PARAMETERS[name] for name in result.names)
        axes.set_xlabel(quantity_label(first))
        axes.set_ylabel(quantity_label(second))
        axes.set_title(parameter_line(result.parameters, result.names), fontsize=7.5)
        figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure

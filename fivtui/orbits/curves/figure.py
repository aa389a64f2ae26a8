"""Figures of branches of limit cycles."""

from typing import Final

import matplotlib as mpl
from matplotlib.figure import Figure

from fivtui.model import PARAMETERS
from fivtui.plotting import STYLE, new_figure, parameter_line, quantity_label

from .events import EventKind
from .result import CycleBranch, CyclePoint

_SIZE: Final = (4.8, 3.9)
_STABLE: Final = "#12803c"
_UNSTABLE: Final = "#1f4fd8"
_EVENT_MARKERS: Final = {
    EventKind.HOPF: "o",
    EventKind.TOUCH: "s",
    EventKind.FOLD: "D",
    EventKind.PERIOD_DOUBLING: "^",
    EventKind.TORUS: "v",
    EventKind.BRANCH: "X",
}
# Unstable cycles so many times larger than the stable ones leave the figure.
_TOWERING: Final = 2.0
_MARGIN: Final = 0.05


def branch_figure(result: CycleBranch) -> Figure:
    """Figure of half peak-to-peak over the parameter: stable full, unstable dashed, events marked.

    Agg canvas, no window.
    """
    with mpl.rc_context(STYLE):
        figure = new_figure(*_SIZE)
        axes = figure.subplots()
        told: set[bool] = set()
        for stable, part in _parts(result):
            axes.plot(
                [point.value for point in part],
                [point.half_range for point in part],
                linestyle="-" if stable else "--",
                color=_STABLE if stable else _UNSTABLE,
                label=None if stable in told else "stable" if stable else "unstable",
            )
            told.add(stable)
        for kind, marker in _EVENT_MARKERS.items():
            found = [event for event in result.events if event.kind is kind]
            if found:
                axes.plot(
                    [event.value for event in found],
                    [0.5 * (event.y_max - event.y_min) for event in found],
                    linestyle="none",
                    marker=marker,
                    markersize=5.0,
                    markerfacecolor="white",
                    color="black",
                    label=str(kind),
                )
        axes.set_xlabel(quantity_label(PARAMETERS[result.name]))
        axes.set_ylabel("Half peak-to-peak of $y$ (m)")
        top = max(point.half_range for point in result.points)
        met = max((point.half_range for point in result.points if point.stable), default=top)
        # A branch that grows without bounds would flatten all that can be met.
        top = min(top, _TOWERING * met)
        axes.set_ylim(-_MARGIN * top, (1.0 + _MARGIN) * top)
        axes.set_title(parameter_line(result.parameters, (result.name,)), fontsize=7.5)
        figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure


def _parts(result: CycleBranch) -> list[tuple[bool, list[CyclePoint]]]:
    # Parts of the same stability; an event is shared by the parts that it separates.
    met = {(event.value, event.period) for event in result.events}
    parts: list[tuple[bool, list[CyclePoint]]] = []
    for place, point in enumerate(result.points):
        at_event = (point.value, point.period) in met
        after = result.points[place + 1] if place + 1 < len(result.points) else point
        if not parts:
            parts.append((point.stable, [point]))
        elif at_event and after.stable != parts[-1][0]:
            parts[-1][1].append(point)
            parts.append((after.stable, [point]))
        elif at_event or point.stable == parts[-1][0]:
            parts[-1][1].append(point)
        else:
            parts.append((point.stable, [parts[-1][1][-1], point]))
    return parts

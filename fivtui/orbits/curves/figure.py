"""Figures of branches of limit cycles."""

from collections.abc import Mapping
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fivtui.charts import (
    STYLE,
    WIDTH,
    math_symbol,
    new_figure,
    parameter_line,
    quantity_label,
)
from fivtui.model import ALL_PARAMETERS
from fivtui.transient import Request, integrate

from .events import EventKind
from .result import CycleBranch, CyclePoint

_SIZE: Final = (WIDTH, 4.4)
_STABLE: Final = "#12803c"
_UNSTABLE: Final = "#1f4fd8"
_EVENT_MARKERS: Final = {
    EventKind.HOPF: "o",
    EventKind.TOUCH: "s",
    EventKind.FOLD: "D",
    EventKind.PERIOD_DOUBLING: "^",
    EventKind.TORUS: "v",
    EventKind.BRANCH: "X",
    EventKind.STICK: "P",
    EventKind.REVERSE_SLIP: "<",
    EventKind.ORDER: "*",
}
_COLOURS: Final = ("#c0392b", "#d68910", "#6c3483", "#117a65")
_SAMPLES: Final = 401
# Multipliers beyond this are drawn on a logarithmic axis.
_FAR: Final = 3.0
# Unstable cycles so many times larger than the stable ones leave the figure.
_TOWERING: Final = 2.0
_MARGIN: Final = 0.05


def branch_figure(result: CycleBranch) -> Figure:
    """Figure of a branch: half peak-to-peak over the parameter, orbits, and multipliers.

    Stable cycles are full, unstable ones dashed. Orbits are those at the first events and of the
    stable cycle next to the parameter set's own value, in the plane of y and its velocity;
    multipliers are those of all cycles in the complex plane, with the unit circle. Agg canvas, no
    window.
    """
    with mpl.rc_context(STYLE):
        figure = new_figure(*_SIZE)
        panels = figure.subplot_mosaic(
            [["branch", "orbits"], ["branch", "multipliers"]], width_ratios=[1.5, 1.0]
        )
        chosen = _chosen(result)
        _draw_branch(panels["branch"], result, chosen)
        _draw_orbits(panels["orbits"], result, chosen)
        _draw_multipliers(panels["multipliers"], result)
        figure.suptitle(parameter_line(result.parameters, (result.name,)), fontsize=7.5)
        handles, labels = panels["branch"].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=8, frameon=False)
    return figure


def _draw_branch(axes: Axes, result: CycleBranch, chosen: Mapping[CyclePoint, str]) -> None:
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
    for point, colour in chosen.items():
        axes.plot(point.value, point.half_range, marker=".", markersize=4.0, color=colour, zorder=3)
    axes.set_xlabel(quantity_label(ALL_PARAMETERS[result.name]))
    axes.set_ylabel("Half peak-to-peak of $y$ (m)")
    top = _top(result)
    axes.set_ylim(-_MARGIN * top, (1.0 + _MARGIN) * top)


def _draw_orbits(axes: Axes, result: CycleBranch, chosen: Mapping[CyclePoint, str]) -> None:
    spec = ALL_PARAMETERS[result.name]
    for point, colour in chosen.items():
        request = Request(
            result.system.with_values({result.name: point.value}),
            t_end=point.period,
            start=point.start,
            samples=_SAMPLES,
        )
        motion = integrate(request).trajectory
        assert motion is not None  # noqa: S101
        axes.plot(
            motion.y,
            motion.vy,
            linestyle="-" if point.stable else "--",
            linewidth=0.9,
            color=colour,
            label=f"{math_symbol(spec.symbol)} = {point.value:.4g}",
        )
    if result.separation:
        axes.axvline(0.0, color="0.6", linewidth=0.6)
    axes.set_xlabel("$y$ (m)")
    axes.set_ylabel("$\\dot{y}$ (m/s)")
    axes.legend(
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=2,
        fontsize=6.0,
        frameon=False,
        handlelength=1.5,
    )


def _draw_multipliers(axes: Axes, result: CycleBranch) -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(np.cos(angles), np.sin(angles), color="0.6", linewidth=0.6)
    for stable, colour in ((False, _UNSTABLE), (True, _STABLE)):
        values = np.array(
            [
                value
                for point in result.points
                if point.stable == stable
                for value in point.multipliers
            ]
        )
        if values.size:
            axes.plot(values.real, values.imag, ".", markersize=2.0, color=colour)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("Re multiplier")
    axes.set_ylabel("Im multiplier")
    largest = max(abs(value) for point in result.points for value in point.multipliers)
    if largest > _FAR:
        axes.set_xscale("symlog", linthresh=_FAR)
        axes.set_aspect("auto")


def _top(result: CycleBranch) -> float:
    # A branch that grows without bounds would flatten all that can be met.
    top = max(point.half_range for point in result.points)
    met = max((point.half_range for point in result.points if point.stable), default=top)
    return min(top, _TOWERING * met)


def _chosen(result: CycleBranch) -> dict[CyclePoint, str]:
    # Cycles whose orbits are drawn, with their colours: at events, and the stable one next to the
    # parameter set's own value. Much larger ones would flatten it.
    met = {(event.value, event.period) for event in result.events}
    own = getattr(result.parameters, result.name)
    seen = [point for point in result.points if point.half_range <= _top(result)]
    stable = sorted(
        (point for point in seen if point.stable and (point.value, point.period) not in met),
        key=lambda point: abs(point.value - own),
    )[:1]
    limit = _TOWERING * max((point.half_range for point in stable), default=np.inf)
    at_events = [point for point in seen if (point.value, point.period) in met]
    points = [point for point in at_events if point.half_range <= limit][: len(_COLOURS) - 1]
    return dict(zip([*points, *stable] or seen[-1:], _COLOURS, strict=False))


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

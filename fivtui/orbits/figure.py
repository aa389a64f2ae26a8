"""Figures of attractors along a parameter and of slices of basins."""

from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fivtui.charts import (
    STYLE,
    math_symbol,
    math_unit,
    new_figure,
    parameter_line,
    quantity_label,
)
from fivtui.model import ALL_PARAMETERS
from fivtui.transient import START_SPECS

from .basins import Basin
from .branches import DIRECTIONS, Continuation
from .explorer import AT_REST, Kind

_SIZE: Final = (4.8, 3.9)
_MARKERS: Final = {"up": "^", "down": "v"}
_COLOURS: Final = {
    Kind.EQUILIBRIUM: "black",
    Kind.CONTACT_CYCLE: "#1f4fd8",
    Kind.SEPARATING_CYCLE: "#12803c",
    Kind.STICK_SLIP_CYCLE: "#c2570c",
    Kind.STICK: "0.45",
}
_SHADE: Final = "0.92"
_PLAIN: Final = "white"
_FILLS: Final = ("#a8c8a0", "#8fa8e0", "#e0b080", "#c090c8", "#80c0c0", "#d0c060", "0.6")
_HATCHES: Final = ("///", "...", "xxx", "\\\\\\", "+++", "ooo", "|||")


def continuation_figure(result: Continuation) -> Figure:
    """Figure of half peak-to-peak over the parameter; coexistence is shaded.

    Triangles point in the direction in which an attractor was found. Agg canvas, no window.
    """
    figure, axes = _new_figure()
    with mpl.rc_context(STYLE):
        _shade(axes, result)
        for kind, colour in _COLOURS.items():
            for direction in DIRECTIONS:
                found = [
                    (point.value, point.attractor.half_range)
                    for point in result.points
                    if point.attractor.kind is kind and direction in point.directions
                ]
                if found:
                    axes.plot(
                        *zip(*found, strict=True),
                        linestyle="none",
                        marker=_MARKERS[direction],
                        markersize=4.5,
                        markerfacecolor="none",
                        color=colour,
                        label=f"{kind}, {direction}",
                    )
        axes.set_xlabel(quantity_label(ALL_PARAMETERS[result.name]))
        axes.set_ylabel("Half peak-to-peak of $y$ (m)")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.set_title(parameter_line(result.parameters, (result.name,)), fontsize=7.5)
        figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def _shade(axes: Axes, result: Continuation) -> None:
    values = result.values
    edges = np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])
    spans = [
        (edges[index], edges[index + 1] - edges[index])
        for index, value in enumerate(values.tolist())
        if value in result.coexisting
    ]
    if spans:
        axes.broken_barh(
            spans,
            (0.0, 1.0),
            transform=axes.get_xaxis_transform(),
            facecolor=_SHADE,
            linewidth=0.0,
            zorder=0.0,
            label="coexistence",
        )


def basin_figure(result: Basin) -> Figure:
    """Figure of which attractor each start reaches; the basin of rest is white.

    The others differ in colour and hatching. Both axes need two or more values. Agg canvas, no
    window.
    """
    figure, axes = _new_figure()
    fills, hatches, place = [], [], 0
    for attractor in result.attractors:
        rests = attractor.kind in AT_REST
        fills.append(_PLAIN if rests else _FILLS[place % len(_FILLS)])
        hatches.append("" if rests else _HATCHES[place % len(_HATCHES)])
        place += not rests
    first, second = result.axes
    count = len(result.attractors)
    with mpl.rc_context({**STYLE, "axes.grid": False, "hatch.linewidth": 0.3}):
        axes.grid(visible=False)
        axes.pcolormesh(
            first,
            second,
            result.reached.T,
            shading="nearest",
            cmap=ListedColormap(fills),
            norm=BoundaryNorm(np.arange(count + 1) - 0.5, count),
            rasterized=True,
        )
        for index, hatch in enumerate(hatches):
            inside = np.equal(result.reached.T, index).astype(float)
            if hatch and inside.min() < inside.max():
                style: dict[str, Any] = {"colors": "none", "hatches": [hatch]}
                axes.contourf(first, second, inside, levels=[0.5, 1.5], **style)
                axes.contour(first, second, inside, levels=[0.5], colors="black", linewidths=0.8)
        handles = [
            Patch(
                facecolor=fill, hatch=hatch, edgecolor="black", linewidth=0.5, label=a.description
            )
            for fill, hatch, a in zip(fills, hatches, result.attractors, strict=True)
        ]
        axes.set_xlabel(quantity_label(START_SPECS[result.names[0]]))
        axes.set_ylabel(quantity_label(START_SPECS[result.names[1]]))
        axes.set_title(
            f"{parameter_line(result.parameters)}\n{_other_values(result)}", fontsize=7.5
        )
        figure.legend(handles=handles, loc="outside lower center", frameon=False)
    return figure


def _other_values(result: Basin) -> str:
    values = zip(START_SPECS.values(), result.start, strict=True)
    return ", ".join(
        f"{math_symbol(spec.symbol)} = {value:.4g} {math_unit(spec.unit)}"
        for spec, value in values
        if spec.name not in result.names
    )


def _new_figure() -> tuple[Figure, Axes]:
    with mpl.rc_context(STYLE):
        figure = new_figure(*_SIZE)
        return figure, figure.subplots()

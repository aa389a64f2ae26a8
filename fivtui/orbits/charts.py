"""Charts of attractors along a parameter and of slices of basins."""

from typing import Final

import numpy as np

from fivtui.charts import (
    STRONG,
    Backdrop,
    Chart,
    Label,
    Shade,
    Sheet,
    Strip,
    Trace,
    axis_label,
    math_symbol,
    math_unit,
    parameter_text,
    series_role,
)
from fivtui.model import ALL_PARAMETERS
from fivtui.transient import START_SPECS

from .attractor_continuation import DIRECTIONS, Continuation
from .basins import Basin
from .explorer import AT_REST, Kind

# Width and height of a figure, inches.
_FIGURE_SIZE: Final = (4.8, 3.9)
# Characters for the terminal, and markers of matplotlib, by direction.
_MARKS: Final = {"up": ("▲", "^"), "down": ("▼", "v")}
# Unsettled and unbounded motion has no amplitude, and is not drawn. `Kind.STICK` is rest on a belt
# that is at rest.
_COLOURS: Final = {
    Kind.EQUILIBRIUM: STRONG,
    Kind.CONTACT_CYCLE: "series-1",
    Kind.SEPARATING_CYCLE: "series-4",
    Kind.STICK_SLIP_CYCLE: "series-2",
    Kind.STICK: "series-7",
}
_REST_SHADE: Final = Shade(" ", style="safe")
# Shades of the basins of cycles, in the order of the attractors.
_CYCLE_SHADES: Final = tuple(
    Shade(character, style=series_role(index), hatch=hatch, strength=0.4)
    for index, (character, hatch) in enumerate(
        zip("░▒▓█·:×", ("///", "...", "xxx", "\\\\\\", "+++", "ooo", "|||"), strict=True)
    )
)


def continuation_sheet(result: Continuation) -> Sheet:
    """Half peak-to-peak over the parameter; intervals of coexistence are marked along x.

    Triangles point in the direction in which an attractor was found.
    """
    traces = []
    for kind, colour in _COLOURS.items():
        for direction in DIRECTIONS:
            points = [
                (point.value, point.attractor.half_range)
                for point in result.points
                if point.attractor.kind is kind and direction in point.directions
            ]
            x, y = np.array(points, dtype=float).reshape(-1, 2).T
            mark, marker = _MARKS[direction]
            # Role and marker are the style in figures.
            traces.append(
                Trace(
                    f"{kind}, {direction}",
                    x,
                    y,
                    look="points",
                    ordered=False,
                    mark=mark,
                    colour=colour,
                    role="attractor",
                    marker=marker,
                )
            )
    largest = max((float(trace.y.max(initial=0.0)) for trace in traces), default=0.0)
    intervals = _coexistence_intervals(result)
    # Margins for markers at the ends of the x axis, and in figures below y = 0.
    chart = Chart(
        axis_label(ALL_PARAMETERS[result.name]),
        Label("±y (m)", "Half peak-to-peak of $y$ (m)"),
        tuple(traces),
        strips=(Strip(label="coexist", meaning="coexistence", intervals=intervals),),
        x_margins=True,
        figure_y=(-0.05 * largest, None),
    )
    return Sheet([[chart]], _FIGURE_SIZE, parameter_text(result.parameters, (result.name,)))


def _coexistence_intervals(result: Continuation) -> list[tuple[float, float]]:
    # Intervals around values of coexistence, up to the midpoints to their neighbours.
    values, coexisting = result.values, set(result.coexisting)
    midpoints = 0.5 * (values[1:] + values[:-1])
    # The interval around values[i] is from edges[i] to edges[i + 1].
    edges = np.concatenate([values[:1], midpoints, values[-1:]]).tolist()
    return [
        (edges[index], edges[index + 1])
        for index, value in enumerate(values.tolist())
        if value in coexisting
    ]


def basin_sheet(result: Basin) -> Sheet:
    """The attractor of every start; the basin of rest is white.

    The basins of cycles differ in colour and hatching.
    """
    shades, cycle_count = [], 0
    for attractor in result.attractors:
        # The equilibrium, or rest by stick.
        at_rest = attractor.kind in AT_REST
        shade = _REST_SHADE if at_rest else _CYCLE_SHADES[cycle_count % len(_CYCLE_SHADES)]
        cycle_count += not at_rest
        shades.append(shade._replace(text=attractor.description, name=attractor.description))
    (x, y), (x_label, y_label) = result.axes, map(axis_label, result.grid.specs)
    backdrop = Backdrop(
        x,
        y,
        levels=result.reached,
        shades=shades,
        values=result.reached.astype(float),
        label="attractor",
    )
    chart = Chart(x_label, y_label, (), backdrop=backdrop)
    fixed_components = ", ".join(
        f"{math_symbol(spec.symbol)} = {value:.4g} {math_unit(spec.unit)}"
        for spec, value in zip(START_SPECS.values(), result.start, strict=True)
        if spec.name not in result.names
    )
    return Sheet(
        [[chart]], _FIGURE_SIZE, f"{parameter_text(result.parameters)}\n{fixed_components}"
    )

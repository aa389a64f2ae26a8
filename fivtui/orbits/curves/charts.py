"""Charts of branches of limit cycles: the branch, orbits on it, and multipliers.

The `role` of a trace is the key of its style in figures. Along a trace that is not `ordered` x may
fall.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    FIGURE_WIDTH,
    Chart,
    Guide,
    Label,
    Sheet,
    Trace,
    axis_label,
    math_symbol,
    parameter_text,
)
from fivtui.model import ALL_PARAMETERS
from fivtui.transient import Request, integrate

from .events import EventKind
from .result import CycleBranch, CyclePoint, event_at

FloatArray = NDArray[np.float64]

# Width and height of a figure, inches.
_FIGURE_SIZE: Final = (FIGURE_WIDTH, 4.4)
# Letters for the terminal, and markers of matplotlib. A cycle begins to touch y = 0, to stick or to
# be faster than the belt (reverse slip), or the order of its modes of contact changes. N is the
# Neimark-Sacker point at which a torus begins.
_EVENT_MARKS: Final[Mapping[EventKind, tuple[str, str]]] = {
    EventKind.HOPF: ("H", "o"),
    EventKind.TOUCH: ("T", "s"),
    EventKind.FOLD: ("F", "D"),
    EventKind.PERIOD_DOUBLING: ("P", "^"),
    EventKind.TORUS: ("N", "v"),
    EventKind.BRANCH: ("B", "X"),
    EventKind.STICK: ("S", "P"),
    EventKind.REVERSE_SLIP: ("R", "<"),
    EventKind.ORDER: ("O", "*"),
}
# Colours of the orbits that are drawn, which also limit their number.
_COLOURS: Final = ("series-4", "series-5", "series-6", "series-3")
_ORBIT_SAMPLES: Final = 401
# Size of multipliers up to which the axes are linear; beyond it they are logarithmic.
_LINEAR_SIZE: Final = 3.0
# Top of the figure, relative to the largest stable cycle; larger unstable cycles are cut off.
_TOP_RATIO: Final = 2.0
# Greatest size of the orbits at events, relative to the stable orbit drawn beside them.
_ORBIT_RATIO: Final = 2.0
# Margin above and below the branch, relative to the top of the figure.
_MARGIN: Final = 0.05
# Length of dashes in the terminal, relative to the size of the chart, and points per dash.
_DASH_LENGTH: Final = 0.02
_DASH_POINTS: Final = 8


def event_name(kind: EventKind) -> str:
    """The name of an event in charts; Hopf, the name of a person, has a capital."""
    return "Hopf" if kind is EventKind.HOPF else str(kind).replace("-", " ")


def branch_chart(result: CycleBranch, edited: float | None) -> Chart:
    """Half peak-to-peak over the parameter: stable cycles full, unstable ones dashed, events.

    `edited` is the value of the parameter in the editor, marked in the chart.
    """
    chart = _full_chart(result)
    stable, unstable, *events = chart.traces
    x, y = _dash(unstable.x, unstable.y, branch_extents(result))
    return replace(
        chart,
        traces=(stable, replace(unstable, x=x, y=y), *events),
        guides=() if edited is None else (Guide(edited, "now"),),
    )


def branch_sheet(result: CycleBranch) -> Sheet:
    """A branch, orbits in the plane of y and its velocity, and multipliers in the complex plane.

    Orbits are drawn at the first events, and for the stable cycle nearest to the parameter set.
    Multipliers of all cycles are drawn with the unit circle.
    """
    drawn_cycles = _choose_cycles(result)
    branch, top = _full_chart(result), _figure_top(result)
    points = [
        Trace(
            "",
            np.array([point.value]),
            np.array([point.half_range]),
            role="chosen cycle",
            colour=colour,
        )
        for point, colour in drawn_cycles.items()
    ]
    branch = replace(
        branch,
        traces=(*branch.traces, *points),
        figure_y=(-_MARGIN * top, (1.0 + _MARGIN) * top),
    )
    return Sheet(
        [[branch], [_orbit_chart(result, drawn_cycles), _multiplier_chart(result)]],
        _FIGURE_SIZE,
        parameter_text(result.parameters, (result.name,)),
        widths=(1.5, 1.0),
    )


def branch_extents(result: CycleBranch) -> tuple[float, float]:
    """Extents of a branch along the parameter and along half peak-to-peak, both above zero."""
    values, heights = _coordinates(result)
    return max(float(np.ptp(values)), 1e-300), max(float(heights.max()), 1e-300)


def _coordinates(result: CycleBranch) -> tuple[FloatArray, FloatArray]:
    # Parameter and half peak-to-peak, m, of the cycles.
    values = np.array([point.value for point in result.points])
    return values, np.array([point.half_range for point in result.points])


def _full_chart(result: CycleBranch) -> Chart:
    values, heights = _coordinates(result)
    stable = np.array([point.stable for point in result.points])
    curves = [
        Trace(name, *_masked_curve(values, heights, mask), ordered=False, mark=mark, role=name)
        for name, mask, mark in (("stable", stable, "●"), ("unstable", ~stable, "○"))
    ]
    events = [
        Trace(
            Label(event_name(kind), str(kind)),
            np.array([event.value for event in kind_events]),
            np.array([0.5 * (event.y_max - event.y_min) for event in kind_events]),
            look="points",
            ordered=False,
            mark=mark,
            role="event",
            marker=marker,
        )
        for kind, (mark, marker) in _EVENT_MARKS.items()
        if (kind_events := [event for event in result.events if event.kind is kind])
    ]
    spec = ALL_PARAMETERS[result.name]
    return Chart(
        Label(f"{spec.symbol} ({spec.unit})" if spec.unit else spec.symbol, axis_label(spec).math),
        Label("±y (m)", "Half peak-to-peak of $y$ (m)"),
        (*curves, *events),
        note=f"{len(result.points)} limit cycles",
        # The limits of x are not at the ends of a branch that turns back.
        x_margins=True,
    )


def _orbit_chart(result: CycleBranch, colours: Mapping[CyclePoint, str]) -> Chart:
    # Orbits of cycles, in their colours, in the plane of y and ẏ.
    symbol = math_symbol(ALL_PARAMETERS[result.name].symbol)
    traces = []
    for point, colour in colours.items():
        request = Request(
            result.system.with_values({result.name: point.value}),
            t_end=point.period,
            start=point.start,
            samples=_ORBIT_SAMPLES,
        )
        motion = integrate(request).trajectory
        assert motion is not None  # noqa: S101
        traces.append(
            Trace(
                Label(f"{result.name} = {point.value:.4g}", f"{symbol} = {point.value:.4g}"),
                motion.y,
                motion.vy,
                ordered=False,
                role="stable orbit" if point.stable else "unstable orbit",
                colour=colour,
            )
        )
    return Chart(
        Label("y (m)", "$y$ (m)"),
        Label("ẏ (m/s)", "$\\dot{y}$ (m/s)"),
        tuple(traces),
        # Contact is lost at y = 0.
        guides=(Guide(0.0),) if result.separation else (),
        legend="above",
    )


def _multiplier_chart(result: CycleBranch) -> Chart:
    angles = np.linspace(0.0, 2.0 * np.pi, 181)
    traces = [Trace("", np.cos(angles), np.sin(angles), ordered=False, role="unit circle")]
    for stable, role in ((False, "unstable multipliers"), (True, "stable multipliers")):
        cycles = [point for point in result.points if point.stable == stable]
        values = np.array([value for point in cycles for value in point.multipliers])
        if values.size:
            traces.append(
                Trace("", values.real, values.imag, look="dots", ordered=False, role=role)
            )
    largest = max(abs(value) for point in result.points for value in point.multipliers)
    return Chart(
        "Re multiplier",
        "Im multiplier",
        tuple(traces),
        to_scale=True,
        linear_within=_LINEAR_SIZE if largest > _LINEAR_SIZE else 0.0,
    )


def _figure_top(result: CycleBranch) -> float:
    # Highest point of the figure: a branch that grows without bounds would flatten stable cycles.
    largest = max(point.half_range for point in result.points)
    stable = max((point.half_range for point in result.points if point.stable), default=largest)
    return min(largest, _TOP_RATIO * stable)


def _choose_cycles(result: CycleBranch) -> dict[CyclePoint, str]:
    # Cycles whose orbits are drawn, with their colours: at events, and the stable cycle nearest to
    # the parameter set. Cycles much larger than this stable cycle are left out.
    set_value = getattr(result.parameters, result.name)
    visible = [point for point in result.points if point.half_range <= _figure_top(result)]
    nearest_stable = min(
        (point for point in visible if point.stable and event_at(result, point) is None),
        key=lambda point: abs(point.value - set_value),
        default=None,
    )
    limit = np.inf if nearest_stable is None else _ORBIT_RATIO * nearest_stable.half_range
    at_events = [point for point in visible if event_at(result, point) is not None]
    # The stable cycle needs one of the colours.
    cycles = [point for point in at_events if point.half_range <= limit][: len(_COLOURS) - 1]
    if nearest_stable is not None:
        cycles.append(nearest_stable)
    if not cycles:
        cycles = visible[-1:]
    return dict(zip(cycles, _COLOURS, strict=False))


def _masked_curve(
    x: FloatArray, y: FloatArray, mask: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    # The points of a curve in a mask. Each run of points is extended by the next point of the
    # curve, so that masked curves meet; NaN separates the runs.
    runs_x: list[FloatArray] = []
    runs_y: list[FloatArray] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    for begin, end in edges.reshape(-1, 2).tolist():
        run = slice(begin, min(end + 1, x.size))
        runs_x += [x[run], np.array([np.nan])]
        runs_y += [y[run], np.array([np.nan])]
    if not runs_x:
        return np.empty(0), np.empty(0)
    return np.concatenate(runs_x[:-1]), np.concatenate(runs_y[:-1])


def _dash(
    x: FloatArray, y: FloatArray, extents: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    # A dashed curve, resampled at equal distances; every second dash is a gap of NaN. The extents
    # of the chart along x and y scale the distances.
    if x.size < 2:
        return x, y
    x_extent, y_extent = extents
    steps = np.hypot(np.diff(x) / x_extent, np.diff(y) / y_extent)
    length = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0))])
    count = max(math.ceil(length[-1] / _DASH_LENGTH * _DASH_POINTS), 2)
    positions = np.linspace(0.0, length[-1], count)
    curves = (np.interp(positions, length, values) for values in (x, y))
    in_dash = (positions / _DASH_LENGTH).astype(int) % 2 == 0
    dashed_x, dashed_y = (np.where(in_dash, values, np.nan) for values in curves)
    return dashed_x, dashed_y

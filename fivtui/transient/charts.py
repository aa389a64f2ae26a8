"""Charts of transients: time histories, phase portraits, and differences of runs.

The laboratory (the terminal program) shows the charts one by one; `transient_sheet` combines them
into a figure by matplotlib.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.charts import (
    CASE_COLOURS,
    FIGURE_WIDTH,
    Chart,
    Guide,
    Label,
    Sheet,
    Strip,
    Trace,
    math_symbol,
    math_unit,
    value_label,
)
from fivtui.model import ALL_PARAMETERS, COLUMNS, InputError, Mode, System, check_known

from .files import finite_trajectory
from .result import Transient
from .trajectory import Trajectory

FloatArray = NDArray[np.float64]
# Starts and ends of intervals of time, s.
Intervals = Sequence[tuple[float, float]]

# Symbols of the columns of a trajectory that differ from their names.
_SYMBOLS: Final = {"vx": "ẋ", "vy": "ẏ"}
_COLUMNS_BY_NAME: Final = {column.name: column for column in COLUMNS}
TIME_LABEL: Final = Label("t (s)", "Time $t$ (s)")
# Marker of sticking in phase portraits.
_STICK_MARK: Final = "■"
# Columns of a trajectory that a figure shows by default, one per row.
_DEFAULT_QUANTITIES: Final = ("P", "x", "y")
# Markers in figures, for runs that all consider separation, or that all ignore it.
_MARKERS: Final = ("", "o", "s", "^", "D", "v")
# Range of y, relative to its greatest size, below which a motion is at rest.
_REST_TOLERANCE: Final = 1e-9
# Heights, inches: of a row of charts, of all rows at least, and of the margins.
_ROW_HEIGHT: Final = 1.85
_MIN_HEIGHT: Final = 2.3
_MARGIN_HEIGHT: Final = 0.85
# Approximate number of cycles in the enlarged end of a run that has at least twice as many.
_LAST_CYCLES: Final = 8
# Number of cycles above which dashes and shading are too narrow to be seen.
_MAX_SHADED: Final = 120
# The role of a line selects its style in figures. With the suffix `_THIN` the line is thin. With
# `_FINE` it is also solid: for windows of so many cycles that dashes and shading cannot be seen.
_THIN: Final = ", thin"
_FINE: Final = ", fine"


def column_label(name: str) -> Label:
    """Symbol and unit of a trajectory's column; in figures also its meaning."""
    column = _COLUMNS_BY_NAME[name]
    meaning = column.meaning.capitalize().replace(" ", "\n")
    return Label(
        f"{_SYMBOLS.get(name, name)} ({column.unit})",
        f"{meaning} {math_symbol(name)} ({math_unit(column.unit)})",
    )


@dataclass(frozen=True, slots=True, eq=False)
class PlottedRun:
    """A trajectory with its intervals of separation and stick, and the style of its lines.

    Attributes
    ----------
    name : str
        Name in the legend.
    trajectory : Trajectory
        The samples.
    separated : sequence of (start, end)
        Intervals off the belt, s.
    t_end : float
        Horizon, s.
    mark, colour : str
        Character and colour of the lines in the terminal; see `Trace`.
    v_belt : float or None
        Speed of the belt, m/s; None if it varies or is not limited.
    stuck : sequence of (start, end) or None
        Intervals of stick, s; None if the belt is always faster than the slider.
    number : int
        Number of the run in the laboratory; 0 if none.
    marker, role : str
        Marker and style of the lines in figures; see `Trace`.
    """

    name: str
    trajectory: Trajectory
    separated: Intervals
    t_end: float
    mark: str = ""
    colour: str = ""
    v_belt: float | None = None
    stuck: Intervals | None = None
    number: int = 0
    marker: str = ""
    role: str = ""

    def trace(
        self, x: FloatArray, y: FloatArray, *, ordered: bool = True, along: FloatArray | None = None
    ) -> Trace:
        """A trace of points (x, y) with the name and the style of the run.

        `along` has values along the curve, at which cursors stand.
        """
        return Trace(
            self.name,
            x,
            y,
            ordered=ordered,
            mark=self.mark,
            colour=self.colour,
            curve_values=along,
            number=self.number,
            marker=self.marker,
            role=self.role,
        )

    def samples_in(self, window: tuple[float, float]) -> slice:
        """Indices of the samples in a window of time, s, up to the first at or after its end."""
        begin, end = np.searchsorted(self.trajectory.t, window, side="left").tolist()
        return slice(begin, end + 1)


def plotted_run(
    result: Transient, name: str = "", mark: str = "", colour: str = "", number: int = 0
) -> PlottedRun | None:
    """A transient ready for plotting; None if it has no samples."""
    if result.trajectory is None:
        return None
    return PlottedRun(
        name,
        result.trajectory,
        result.separated_intervals,
        result.t_end,
        mark,
        colour,
        v_belt=_constant_speed(result.system),
        stuck=None if result.parameters.v_belt is None else result.stick_intervals,
        number=number,
    )


def partial_run(
    trajectory: Trajectory,
    system: System,
    t_end: float,
    *,
    name: str = "",
    mark: str = "",
    colour: str = "",
) -> PlottedRun:
    """The computed part of a run in progress; its intervals are those between samples."""
    on_belt = system.parameters.v_belt is not None
    return PlottedRun(
        name,
        trajectory,
        _mode_intervals(Mode.SEPARATED, trajectory),
        t_end,
        mark,
        colour,
        v_belt=_constant_speed(system),
        stuck=_mode_intervals(Mode.STICK, trajectory) if on_belt else None,
    )


def _constant_speed(system: System) -> float | None:
    # Speed of the belt, m/s; None if it changes over time or is always above that of the slider.
    return None if "v_belt" in system.over_time else system.parameters.v_belt


def _mode_intervals(mode: Mode, trajectory: Trajectory) -> list[tuple[float, float]]:
    # Intervals of a mode, to the resolution of the samples.
    in_mode = np.concatenate(([False], trajectory.mode == mode, [False]))
    edge_indices = np.flatnonzero(np.diff(in_mode))
    edge_times = np.append(trajectory.t, trajectory.t[-1])[edge_indices].tolist()
    return list(zip(edge_times[::2], edge_times[1::2], strict=True))


def contact_strips(separated: Intervals, stuck: Intervals | None) -> tuple[Strip, ...]:
    """Strips that mark separation and, on a belt of finite speed, stick (`stuck` not None)."""
    strip = Strip("off belt", "off the belt", separated)
    return (strip,) if stuck is None else (strip, Strip("stick", "stuck to the belt", stuck))


def time_chart(quantity: str, runs: Sequence[PlottedRun], *, strip: bool, x_axis: bool) -> Chart:
    """A quantity over time, with one trace per run; the first run is drawn on top.

    `quantity` is a column of a trajectory. With `strip` a strip marks the separation and stick of
    the first run; with `x_axis` the ticks of time are labelled.
    """
    return Chart(
        TIME_LABEL,
        column_label(quantity),
        tuple(
            run.trace(run.trajectory.t, getattr(run.trajectory, quantity)) for run in reversed(runs)
        ),
        guides=(Guide(0.0, vertical=False), *_belt_guides(quantity, runs)),
        strips=contact_strips(runs[0].separated, runs[0].stuck) if strip else (),
        x_axis=x_axis,
        x_range=(0.0, max(run.t_end for run in runs)),
    )


def _belt_guides(quantity: str, runs: Sequence[PlottedRun]) -> tuple[Guide, ...]:
    # Guides at constant belt speeds, at which the slider sticks.
    if quantity != "vx":
        return ()
    speeds = dict.fromkeys(run.v_belt for run in runs if run.v_belt is not None)
    return tuple(Guide(speed, "belt", vertical=False, role="belt") for speed in speeds)


def difference_chart(
    quantity: str, run: PlottedRun, baseline: PlottedRun, *, strip: bool, x_axis: bool
) -> Chart:
    """Difference of a quantity between a run and a baseline over their common time.

    `strip` marks the separation and stick of the run. If the sample times differ, the baseline is
    interpolated linearly.
    """
    baseline_t = baseline.trajectory.t
    t = run.trajectory.t[run.trajectory.t <= baseline_t[-1]]
    values = getattr(run.trajectory, quantity)[: t.size]
    baseline_values = getattr(baseline.trajectory, quantity)
    note = f"{run.name} − {baseline.name}"
    if np.array_equal(t, baseline_t[: t.size]):
        differences = values - baseline_values[: t.size]
    else:
        differences = values - np.interp(t, baseline_t, baseline_values)
        note += ", interpolated"
    return Chart(
        TIME_LABEL,
        # A `Label` is a str: the text for the terminal, which alone shows differences.
        f"Δ{column_label(quantity)}",
        (Trace("", t, differences, colour=run.colour),),
        guides=(Guide(0.0, vertical=False),),
        strips=contact_strips(run.separated, run.stuck) if strip else (),
        note=note,
        x_axis=x_axis,
        x_range=(0.0, float(t[-1])),
    )


def second_half(t_end: float) -> tuple[float, float]:
    """Start and end of the second half of a run, over which half peak-to-peak is taken."""
    return 0.5 * t_end, t_end


def window_text(window: tuple[float, float]) -> str:
    """A window of time as text."""
    return f"t {window[0]:.4g} to {window[1]:.4g} s"


def phase_chart(quantity: str, runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """Velocity against displacement within a time window, a trace per run; stick is marked."""
    return _plane_chart(quantity, f"v{quantity}", runs, window)


def path_chart(runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """The path of the slider, y over x, within a time window; stick is marked."""
    return _plane_chart("x", "y", runs, window)


def _plane_chart(
    x_name: str, y_name: str, runs: Sequence[PlottedRun], window: tuple[float, float]
) -> Chart:
    # Curves of one column of the trajectory over another one, with markers in stick.
    traces, stick_traces = [], []
    for run in reversed(runs):
        motion, samples = run.trajectory, run.samples_in(window)
        x, y = getattr(motion, x_name)[samples], getattr(motion, y_name)[samples]
        traces.append(run.trace(x, y, ordered=False, along=motion.t[samples]))
        in_stick = motion.mode[samples] == Mode.STICK
        if in_stick.any():
            stick_traces.append(
                Trace(
                    f"{run.name} stick" if len(runs) > 1 else "stick",
                    x[in_stick],
                    y[in_stick],
                    look="points",
                    ordered=False,
                    mark=_STICK_MARK,
                    colour=run.colour,
                )
            )
    guides = _belt_guides(y_name, runs[:1])
    if "y" in (x_name, y_name):
        # The belt's surface.
        guides = (Guide(0.0, "y = 0", vertical=x_name == "y"), *guides)
    return Chart(
        column_label(x_name),
        column_label(y_name),
        (*traces, *stick_traces),
        guides=guides,
        note=window_text(window),
        x_margins=True,
        curve_label=TIME_LABEL,
    )


# Figures


def transient_sheet(
    runs: Sequence[Transient], quantities: Sequence[str] = _DEFAULT_QUANTITIES, title: str = ""
) -> Sheet:
    """Contact force, horizontal and vertical displacement over time.

    As in Figs. 10 to 12 of "Nonlinear friction-induced vibration of a slider-belt system". A second
    column enlarges the last cycles. Shading marks separation if exactly one run considers it, and
    stick if there is one run only.
    """
    if not runs:
        raise InputError("figure: there is no run to draw")
    for name in quantities:
        check_known("quantity", name, _COLUMNS_BY_NAME)
    plotted = _plotted_runs(runs)
    runs_with_separation = [run for run in runs if run.separation]
    strips = contact_strips(
        runs_with_separation[0].separated_intervals if len(runs_with_separation) == 1 else (),
        runs[0].stick_intervals if len(runs) == 1 else (),
    )
    columns = []
    for window in _windows(max(plotted, key=lambda run: run.t_end)):
        # `time_chart` reverses the runs again: a figure draws them in order, the last one on top.
        drawn_runs = [
            replace(run, role=f"{run.role}{window.role_suffix}") for run in reversed(plotted)
        ]
        charts = [
            time_chart(name, drawn_runs, strip=False, x_axis=name == quantities[-1])
            for name in quantities
        ]
        columns.append(
            [
                replace(
                    chart,
                    strips=() if window.role_suffix == _FINE else strips,
                    figure_x=(window.start, window.end),
                    title=window.title if chart is charts[0] else "",
                )
                for chart in charts
            ]
        )
    height = max(_ROW_HEIGHT * len(quantities), _MIN_HEIGHT) + _MARGIN_HEIGHT
    return Sheet(columns, (FIGURE_WIDTH, height), title)


def _plotted_runs(runs: Sequence[Transient]) -> list[PlottedRun]:
    """Runs in the colours of their cases; markers distinguish the runs of one case."""
    counts = {True: 0, False: 0}
    plotted = []
    for run, label in zip(runs, run_labels(runs), strict=True):
        count, colours = counts[run.separation], CASE_COLOURS[run.separation]
        counts[run.separation] += 1
        plotted.append(
            PlottedRun(
                Label(label, label),
                finite_trajectory(run),
                run.separated_intervals,
                run.t_end,
                colour=colours[count % len(colours)],
                v_belt=_constant_speed(run.system),
                marker=_MARKERS[count % len(_MARKERS)],
                role="considered" if run.separation else "ignored",
            )
        )
    return plotted


def run_labels(runs: Sequence[Transient]) -> list[str]:
    """Legend labels of runs, each different, in matplotlib's mathtext.

    A label has the separation, then the parameters, method and start in which the runs differ.
    """
    varying = [
        name for name in ALL_PARAMETERS if len({getattr(run.parameters, name) for run in runs}) > 1
    ]
    methods_differ = len({run.method for run in runs}) > 1
    labels = []
    for run in runs:
        parts = ["separation considered" if run.separation else "separation ignored"]
        parts += [value_label(name, getattr(run.parameters, name)) for name in varying]
        labels.append(", ".join([*parts, run.method] if methods_differ else parts))
    starts = [f"start ({', '.join(f'{value:.3g}' for value in run.start)})" for run in runs]
    labels = _distinct_labels(labels, [start.replace("-", "−") for start in starts])
    return _distinct_labels(labels, [f"run {number}" for number in range(1, len(runs) + 1)])


def _distinct_labels(labels: Sequence[str], additions: Sequence[str]) -> list[str]:
    """The labels; equal labels get their additions if these differ."""
    distinct_pairs = set(zip(labels, additions, strict=True))
    # Number of different additions of each label.
    addition_counts = Counter(label for label, _ in distinct_pairs)
    return [
        f"{label}, {addition}" if addition_counts[label] > 1 else label
        for label, addition in zip(labels, additions, strict=True)
    ]


class _Window(NamedTuple):
    """Time window of a figure column, s, and the suffix of the role of its lines."""

    title: str
    start: float
    end: float
    role_suffix: str = ""


def _windows(run: PlottedRun) -> list[_Window]:
    """The window of the whole run and, if it has many cycles, that of its last cycles."""
    t_end, period = run.t_end, _period(run.trajectory)
    if period is None or t_end < 2 * _LAST_CYCLES * period:
        return [_Window("", 0.0, t_end)]
    length = _round_number(_LAST_CYCLES * period)
    return [
        _Window("whole run", 0.0, t_end, _FINE if t_end > _MAX_SHADED * period else _THIN),
        _Window(f"last {length:g} s", t_end - length, t_end),
    ]


def _period(trajectory: Trajectory) -> float | None:
    """Mean time between upward crossings of the mean of y, s, in the second half of the run.

    None at rest, and without two crossings.
    """
    is_late = trajectory.t >= 0.5 * trajectory.t[-1]
    t, y = trajectory.t[is_late], trajectory.y[is_late]
    crossings = t[:-1][np.diff(np.sign(y - y.mean())) > 0]
    if crossings.size < 2 or np.ptp(y) <= _REST_TOLERANCE * np.abs(y).max():
        return None
    return float((crossings[-1] - crossings[0]) / (crossings.size - 1))


def _round_number(value: float) -> float:
    """The nearest of 1, 2 and 5 times a power of ten."""
    unit = 10.0 ** math.floor(math.log10(value))
    return unit * min((1.0, 2.0, 5.0, 10.0), key=lambda factor: abs(factor * unit - value))

"""Charts of the paper's panels, and its figures made of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from fivtui.charts import (
    FIGURE_WIDTH,
    LINE_COLOURS,
    Chart,
    Guide,
    Label,
    Sheet,
    Trace,
    axis_label,
    math_symbol,
    parameter_text,
    value_label,
)
from fivtui.model import PARAMETERS
from fivtui.transient import TIME_LABEL, column_label, transient_sheet

from .data import FigureData, FloatArray
from .panels import SEPARATION, Kind, Panel, figure_panels
from .results import PaperResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Columns of every chart by kind of panel; the two modes are a pair of columns in one chart.
_CHART_COLUMNS: Final[Mapping[Kind, Sequence[tuple[str, ...]]]] = {
    "equilibrium": (("y_e",),),
    "eigenvalues": (("omega_1", "omega_2"), ("sigma_1", "sigma_2")),
    "critical mu": (("mu_c",),),
    "amplitude": (("y_peak",), ("y_half_range",)),
}
_LABELS: Final[Mapping[str, Label]] = {
    "y_e": Label("y_e (m)", f"Vertical displacement {math_symbol('y_e')} (m)"),
    "omega_1": Label("Im λ (rad/s)", "Frequency Im $λ$ (rad/s)"),
    "sigma_1": Label("Re λ (1/s)", "Growth rate Re $λ$ (1/s)"),
    "mu_c": Label("μ_c", f"Critical friction coefficient {math_symbol('μ_c')}"),
    "y_peak": Label("peak |y| (m)", "Peak $|y|$ (m)"),
    "y_half_range": Label(
        "half peak-to-peak, 2nd half (m)", "Half peak-to-peak of $y$,\nsecond half of the run (m)"
    ),
}
# Columns whose axis begins at zero, and columns with a line at zero.
_FROM_ZERO: Final = ("mu_c", "y_peak", "y_half_range")
_WITH_ZERO_LINE: Final = ("sigma_1", "y", "x", "P")
# Height of all figures, and width of one with a single chart, inches.
_HEIGHT: Final = 3.1
_SINGLE_WIDTH: Final = 4.6
# Relative distance below which two curves coincide.
_COINCIDENCE_TOL: Final = 1e-6


def figure_charts(panel: Panel, data: FigureData) -> list[Chart]:
    """One or two charts of a panel, with a trace per line."""
    charts = []
    # A panel of transients has a single chart of a single column.
    column_groups = _CHART_COLUMNS.get(panel.kind, [(panel.shown,)])
    for names in column_groups:
        name = names[0]
        traces = tuple(
            _trace(_line_label(data.by, value), line, names, _role(data.by, value, number))
            for number, (value, line) in enumerate(data.lines(), start=1)
        )
        along = data[data.along]
        charts.append(
            Chart(
                TIME_LABEL if data.along == "t" else axis_label(PARAMETERS[data.along]),
                _LABELS.get(name) or column_label(name),
                traces,
                guides=(Guide(0.0, vertical=False),) if name in _WITH_ZERO_LINE else (),
                legend="inside" if panel.kind == "equilibrium" else "below",
                figure_x=(float(along.min()), float(along.max())),
                figure_y=(0.0 if name in _FROM_ZERO else None, None),
            )
        )
    return charts


def _line_label(by: str, value: float) -> Label:
    if by == SEPARATION:
        name = "separation considered" if value else "separation ignored"
        return Label(name, name)
    math = value_label(by, value)
    linear = by == "k_nl" and value == 0.0
    # In the terminal the label of an axis without unit is the symbol.
    symbol = axis_label(replace(PARAMETERS[by], unit=""))
    return Label(f"{symbol} {value:g}", f"linear, {math}" if linear else math)


def _role(by: str, value: float, number: int) -> str:
    # The role of line `number`, from 1, which decides its colour and style.
    if by == SEPARATION:
        return "peak, considered" if value else "peak, ignored"
    return f"line {number}"


def _trace(name: Label, line: FigureData, names: Sequence[str], role: str) -> Trace:
    # The trace of one column, or of the two columns of both modes.
    if len(names) == 1:
        return Trace(name, line[line.along], line[names[0]], role=role)
    # NaN separates the two modes.
    gap = [np.nan]
    first, second = names
    x = np.concatenate([line[line.along], gap, line[line.along]])
    y = np.concatenate([line[first], gap, line[second]])
    return Trace(name, x, y, ordered=False, role=role)


def draw(number: int, results: PaperResults) -> "Figure":
    """Draw a figure of the paper, 2 to 16."""
    from fivtui.charts import sheet_figure

    return sheet_figure(figure_sheet(number, results))


def figure_sheet(number: int, results: PaperResults) -> Sheet:
    """A figure of the paper, 2 to 16; its title lists the parameters that are fixed."""
    panels = figure_panels(number)
    first, *_ = panels
    varied = [name for name in PARAMETERS if name not in first.fixed]
    title = parameter_text(first.lines[0].scene.parameters, varied)
    if first.kind == "transient":
        return transient_sheet(results.runs(first), [first.shown], title)
    tables = [results.table(panel.key) for panel in panels]
    charts = [
        chart
        for panel, data in zip(panels, tables, strict=True)
        for chart in figure_charts(panel, data)
    ]
    if first.kind == "eigenvalues":
        frequencies, growth_rates = (
            replace(chart, traces=tuple(map(_hide_merged, chart.traces))) for chart in charts
        )
        traces = (*growth_rates.traces, *_critical_points(tables[0]))
        charts = [frequencies, replace(growth_rates, traces=traces)]
    if len(charts) > 1:
        charts = [replace(c, title=f"({letter})") for c, letter in zip(charts, "ab", strict=True)]
    width = FIGURE_WIDTH if len(charts) > 1 else _SINGLE_WIDTH
    columns = [[chart] for chart in charts]
    return Sheet(columns, (width, _HEIGHT), title)


def _hide_merged(trace: Trace) -> Trace:
    """Remove the second mode of a trace where it coincides with the first.

    Two dashed curves on top of each other would look solid. The ends of a common part stay.
    """
    # NaN separates the modes in the middle of the trace.
    middle = trace.x.size // 2
    first, second = trace.y[:middle], trace.y[middle + 1 :]
    differs = np.abs(second - first) > _COINCIDENCE_TOL * np.abs(first)
    # Keep the neighbours of points that differ.
    is_kept = np.convolve(differs, np.ones(3), mode="same") > 0.0
    y: FloatArray = np.concatenate([trace.y[: middle + 1], np.where(is_kept, second, np.nan)])
    return replace(trace, y=y)


def _critical_points(data: FigureData) -> list[Trace]:
    """Markers at the critical μ of each line, where the growth rate is zero.

    The last trace has no points: it is the common entry in the legend.
    """
    points = [
        Trace("", line["mu_c"][:1], np.zeros(1), "points", role="critical point", colour=colour)
        for (_, line), colour in zip(data.lines(), LINE_COLOURS, strict=True)
    ]
    no_points = np.full(1, np.nan)
    name = Label("μ_c", math_symbol("μ_c"))
    return [*points, Trace(name, no_points, no_points, "points", role="critical point")]

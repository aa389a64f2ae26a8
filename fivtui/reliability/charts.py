"""Charts of uncertainty studies: histograms by region, Sobol indices, samples by region.

A region has the samples with one outcome. No squeal: μ is below the safe μ. Squeal after a knock: μ
is above it, and only a large disturbance makes the slider vibrate. Squeal by itself: the
equilibrium is unstable.
"""

import math
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.charts import (
    FIGURE_WIDTH,
    Chart,
    Guide,
    Label,
    Sheet,
    Trace,
    axis_label,
    label_with_unit,
    math_symbol,
    meaning_label,
    parameter_text,
)
from fivtui.sweeps import OUTPUTS
from fivtui.transient import VARIABLES

from .result import Uncertainty
from .statistics import rank_inputs

# Short names of quantities for the terminal.
_TERMINAL_NAMES: Final = {
    "growth_rate": "growth rate",
    "critical_mu": "critical μ",
    "safe_mu": "safe μ",
    "y_half_range": "±y 2nd half",
    "P_max": "greatest P",
}
# Regions, the safest first: characters in the terminal, roles in figures.
_MARKS: Final = ("○", "▫", "▲")
_ROLES: Final = ("safe region", "knock region", "squeal region")
_COLOURS: Final = {"safe region": "safe", "knock region": "warning", "squeal region": "danger"}
_QUANTILE_LEVELS: Final = ("0.05", "0.5", "0.95")
_DIGITS: Final = 4
_DOT_COUNT: Final = 2000
# Distance of the bars of an input, one above and one below, from its y = 0, 1, …
_BAR_SHIFT: Final = 0.2
# Axis of Sobol indices: greatest margin around 0 to 1, right end relative to the greatest value.
_INDEX_MARGIN: Final = 0.2
_INDEX_END: Final = 1.04
# The title explains indices that are further than this outside 0 to 1.
_VISIBLE_EXCESS: Final = 0.005
# Figures: panels in a row, characters in a line of a title, bins, and heights in inches.
_PANELS_PER_ROW: Final = 3
_TITLE_WIDTH: Final = 30
_BIN_COUNT: Final = 40
_ROW_HEIGHT: Final = 1.75
_BAR_HEIGHT: Final = 0.19
_BARS_MARGIN: Final = 0.85
_PANEL_HEIGHT: Final = 1.35
_TITLE_HEIGHT: Final = 0.9
# Scatter matrix: points and bins of a panel, and the greatest number of inputs.
_PANEL_DOTS: Final = 400
_PANEL_BINS: Final = 20
_MAX_INPUTS: Final = 6
# Least height of the matrix in heights of a panel, for a single input.
_LEAST_ROWS: Final = 1.3


def probability_text(result: Uncertainty) -> str:
    """The probabilities of a study, with their errors."""
    return "   ".join(
        f"P({quantity_name(name)}) = {estimate.value:.{_DIGITS}g} ± {estimate.error:.1g}"
        for name, estimate in result.probabilities.items()
    )


def quantity_name(name: str) -> str:
    """The name of a quantity or an event in the terminal."""
    return _TERMINAL_NAMES.get(name, name.replace("_", " "))


def displayed_quantity(result: Uncertainty, name: str) -> str:
    """`name` if that quantity has values, else the first one with values; empty without any."""
    names = [name for name, quantiles in result.quantiles.items() if quantiles]
    return name if name in names else next(iter(names), "")


def histogram_chart(result: Uncertainty, quantity: str, bins: int = 60) -> Chart | None:
    """The shares of samples over a quantity, a step line per region, with quantiles."""
    name = displayed_quantity(result, quantity)
    if not name:
        return None
    output, quantiles = OUTPUTS[name], result.quantiles[name]
    label = meaning_label(output.meaning, output.unit, _TERMINAL_NAMES.get(name, ""))
    guides = [Guide(quantiles[level].value, f"{float(level):.0%}") for level in _QUANTILE_LEVELS]
    return replace(_histogram(result, name, label, bins), guides=tuple(guides))


def samples_chart(result: Uncertainty, quantity: str) -> Chart | None:
    """Samples by region over the first two inputs, or over one and a quantity."""
    names = [*result.inputs, *filter(None, [displayed_quantity(result, quantity)])][:2]
    if len(names) < 2:
        return None
    return _scatter(result, names[0], names[1], _DOT_COUNT)


def uncertainty_sheet(result: Uncertainty) -> Sheet:
    """Histograms of outputs by region, Sobol indices with intervals, and inputs by region."""
    histograms = [
        replace(chart, guides=(), x_margins=True, y_label=chart.y_label if index == 0 else "")
        for index, name in enumerate(name for name, values in result.quantiles.items() if values)
        if (chart := histogram_chart(result, name, _BIN_COUNT)) is not None
    ]
    parts = [_panel_rows(histograms, _ROW_HEIGHT)]
    if result.indices:
        index_charts = [index_chart(result, output) for output in result.indices]
        height = _BARS_MARGIN + _BAR_HEIGHT * len(result.inputs)
        parts.append(_panel_rows(index_charts, height))
    parts.append(_scatter_matrix(result))
    return Sheet(
        [],
        (FIGURE_WIDTH, sum(part.size[1] for part in parts) + _TITLE_HEIGHT),
        parameter_text(result.study.parameters, tuple(result.inputs)),
        parts=parts,
        small_text=True,
    )


def index_chart(result: Uncertainty, output: str) -> Chart:
    """First and total Sobol indices of an output as bars with intervals, and linear shares.

    A linear share is the index that the input would have if the output were linear.
    """
    rows = list(reversed(rank_inputs(result.indices[output])))
    positions = np.arange(len(rows), dtype=float)
    traces = []
    for shift, attribute, name in (
        (_BAR_SHIFT, "first", "alone"),
        (-_BAR_SHIFT, "total", "with others"),
    ):
        estimates = [getattr(index, attribute) for _, index in rows]
        value, low, high = np.array(
            [(estimate.value, estimate.low, estimate.high) for estimate in estimates]
        ).T
        traces.append(
            Trace(name, value, positions + shift, look="bars", role=name, intervals=(low, high))
        )
    local = result.local.get(output, {})
    points = [(local[name].share, y) for y, (name, _) in enumerate(rows) if name in local]
    shares, share_y = np.array(points, dtype=float).reshape(-1, 2).T
    traces.append(
        Trace("if linear", shares, share_y, look="points", ordered=False, mark="◆", role="linear")
    )
    meaning = OUTPUTS[output].meaning if output in OUTPUTS else output.replace("_", " ")
    title = textwrap.fill(f"Sobol indices of: {meaning}", _TITLE_WIDTH)
    bars = traces[:2]
    values = np.concatenate([trace.x for trace in bars])
    if values.min() < -_VISIBLE_EXCESS or values.max() > 1.0 + _VISIBLE_EXCESS:
        title += "\n(beyond 0 to 1: sampling error)"
    # Indices of an output with almost no variance may have any value: clip the axis.
    ends = np.concatenate([shares, *(end for trace in bars for end in trace.intervals or ())])
    low, high = float(np.nanmin([0.0, *ends])), float(np.nanmax([1.0, *ends]))
    return Chart(
        "",
        "",
        tuple(traces),
        y_names=[
            Label(axis_label(VARIABLES[name]), math_symbol(VARIABLES[name].symbol))
            for name, _ in rows
        ],
        title=title,
        x_margins=True,
        figure_x=(max(low, -_INDEX_MARGIN), min(_INDEX_END * high, 1.0 + _INDEX_MARGIN)),
    )


def _histogram(result: Uncertainty, name: str, label: str, bins: int) -> Chart:
    values = result.samples(name)
    has_value = ~np.isnan(values)
    low, high = float(values[has_value].min()), float(values[has_value].max())
    if low == high:
        # Equal values need bins of some width, also at 0.
        low, high = low - 0.5 * abs(low) - 1e-9, high + 0.5 * abs(high) + 1e-9
    edges = np.linspace(low, high, bins + 1)
    traces = []
    for (region, inside), role in zip(result.regions().items(), _region_roles(result), strict=True):
        counts, _ = np.histogram(values[has_value & inside], bins=edges)
        # A step line has both edges of every bin.
        step_edges = np.repeat(edges, 2)[1:-1]
        step_shares = np.repeat(counts / has_value.sum(), 2)
        traces.append(Trace(region, step_edges, step_shares, colour=_COLOURS[role], role=role))
    y_label = Label("share of samples", "Share of samples")
    return Chart(label, y_label, tuple(traces), stacked=True)


def _scatter(result: Uncertainty, x_name: str, y_name: str, count: int) -> Chart:
    # At most `count` samples, evenly chosen, as points by region.
    x, y = result.samples(x_name), result.samples(y_name)
    indices = np.linspace(0, x.size - 1, min(count, x.size)).astype(int)
    traces = []
    # Two regions have the first two of the three marks.
    regions = zip(result.regions().items(), _MARKS, _region_roles(result), strict=False)
    for (region, inside), mark, role in regions:
        drawn = indices[inside[indices]]
        traces.append(
            Trace(
                region,
                x[drawn],
                y[drawn],
                look="points",
                ordered=False,
                mark=mark,
                colour=_COLOURS[role],
                role=role,
            )
        )
    return Chart(_label(x_name), _label(y_name), tuple(traces))


def _region_roles(result: Uncertainty) -> Sequence[str]:
    # The roles of the regions; two regions have the first and the last role.
    count = len(result.regions())
    return _ROLES if count == len(_ROLES) else (_ROLES[0], _ROLES[-1])


def _label(name: str) -> Label:
    """Symbol and unit of an input, or the name of an output."""
    if name in OUTPUTS:
        return label_with_unit(name, OUTPUTS[name].unit)
    spec = VARIABLES[name]
    return Label(axis_label(spec), label_with_unit(math_symbol(spec.symbol), spec.unit).math)


def _panel_rows(charts: Sequence[Chart], height: float) -> Sheet:
    """Charts in rows of at most three, of equal length if possible."""
    rows = math.ceil(len(charts) / _PANELS_PER_ROW)
    columns = math.ceil(len(charts) / rows)
    # Charts in reading order, with gaps at the end of the last row; a sheet takes columns.
    cells = [*charts, *[None] * (rows * columns - len(charts))]
    return Sheet(
        [cells[column::columns] for column in range(columns)], (FIGURE_WIDTH, height * rows)
    )


def _scatter_matrix(result: Uncertainty) -> Sheet:
    """A scatter matrix: histograms of the inputs, and below them samples over two inputs."""
    inputs = list(result.inputs)[:_MAX_INPUTS]
    columns: list[list[Chart | None]] = []
    for column, x_name in enumerate(inputs):
        diagonal = replace(
            _histogram(result, x_name, _label(x_name), _PANEL_BINS), y_label="", x_margins=True
        )
        cells = [_scatter(result, x_name, y_name, _PANEL_DOTS) for y_name in inputs[column + 1 :]]
        charts = [replace(chart, x_axis=False) for chart in (diagonal, *cells)]
        charts[-1] = replace(charts[-1], x_axis=True)
        columns.append([*[None] * column, *charts])
    return Sheet(columns, (FIGURE_WIDTH, _PANEL_HEIGHT * max(len(inputs), _LEAST_ROWS)))

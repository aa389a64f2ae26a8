"""Charts of a fit: measured and computed signals over time, and their difference."""

from fivtui.charts import FIGURE_WIDTH, Chart, Sheet, Trace
from fivtui.model import InputError
from fivtui.transient import TIME_LABEL, column_label

from .result import Identification

_PANEL_HEIGHT = 2.2


def fit_charts(result: Identification) -> list[tuple[Chart, Chart]]:
    """A chart of both signals and one of the residuals for each signal of each record."""
    charts = []
    for record in sorted(set(result.record.tolist())):
        for quantity in result.residual_sd:
            rows = (result.record == record) & (result.signal == quantity)
            t, measured, computed = result.t[rows], result.measured[rows], result.computed[rows]
            signals = Chart(
                TIME_LABEL,
                column_label(quantity),
                (
                    Trace("computed", t, computed, role="computed"),
                    Trace("measured", t, measured, role="measured"),
                ),
                note=f"record {record}",
            )
            residuals = Chart(
                TIME_LABEL,
                "measured − computed",
                (Trace("", t, measured - computed, role="deviation"),),
            )
            charts.append((signals, residuals))
    return charts


def identification_sheet(result: Identification) -> Sheet:
    """The charts of all signals, one below the other."""
    charts = [chart for pair in fit_charts(result) for chart in pair]
    if not charts:
        raise InputError("a fit to targets alone has no figure: fit a record as well")
    return Sheet([[*charts]], (FIGURE_WIDTH, _PANEL_HEIGHT * len(charts)))

"""Charts of a trade-off: error against CPU time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.charts import Chart, Guide, Label, Look, Sheet, Trace

from .files import pareto_fronts
from .measure import Tradeoff
from .settings import MeasuredSetting

_SIZE: Final = (7.2, 3.9)
_MARKS: Final = "○□△▽◇×+☆"
_EDITED_MARK: Final = "◆"
# Smaller errors, such as 0, are drawn at this value, because the axis is logarithmic. In figures by
# matplotlib, unlike in the terminal, the axis begins below it.
_MIN_DRAWN_ERROR: Final = 1e-16
_FIGURE_AXIS_START: Final = 0.3 * _MIN_DRAWN_ERROR
# Labels of the axis of errors; half peak-to-peak is that of y over the second half of the run.
_LABELS: Final[Mapping[str, Label]] = {
    "final": Label("error of final state", "Error of the final state (1)"),
    "peak": Label("error of peak", "Error of the peak of $|y|$ (1)"),
    "half_range": Label(
        "error of half peak-to-peak, 2nd half", "Error of half peak-to-peak, second half (1)"
    ),
    "events": Label("error of events (s)", "Error of the switch times (s)"),
}
_SHEET_QUANTITIES: Final = ("final", "peak", "events")


def tradeoff_chart(
    result: Tradeoff, quantity: str, present: MeasuredSetting | None = None
) -> Chart:
    """Error of a quantity against CPU time, a line per method.

    Errors below the guide are within the uncertainty of the reference. `present` is the measured
    setting nearest to that of the scene being edited in the laboratory (the terminal program).
    """
    by_method: dict[str, list[MeasuredSetting]] = {}
    for row in result.rows:
        by_method.setdefault(row.setting.label, []).append(row)
    traces = [
        _trace(method, rows, quantity, "marked", mark=_MARKS[index % len(_MARKS)], role="series")
        for index, (method, rows) in enumerate(by_method.items())
    ]
    if present is not None:
        traces.append(_trace("now", [present], quantity, "points", mark=_EDITED_MARK))
    floor = result.floor.of(quantity)
    uncertainty = Guide(floor, "uncertainty", vertical=False)
    return Chart(
        Label("CPU (s)", "CPU time of a run (s)"),
        _LABELS[quantity],
        tuple(traces),
        guides=(uncertainty,) if floor > 0.0 else (),
        x_margins=True,
        log="xy",
        figure_y=(_FIGURE_AXIS_START, None),
    )


def tradeoff_sheet(result: Tradeoff) -> Sheet:
    """Errors of final state, peak and switch times side by side.

    The wide grey line is the Pareto front.
    """
    fronts = pareto_fronts(result)
    charts = []
    for quantity in _SHEET_QUANTITIES:
        chart = tradeoff_chart(result, quantity)
        front = _trace("", fronts[quantity], quantity, "line", role="Pareto front")
        floor_guide = Guide(
            max(result.floor.of(quantity), _MIN_DRAWN_ERROR),
            "uncertainty",
            vertical=False,
            role="floor",
        )
        charts.append(replace(chart, traces=(front, *chart.traces), guides=(floor_guide,)))
    return Sheet([[chart] for chart in charts], _SIZE)


def _trace(
    name: str,
    rows: Sequence[MeasuredSetting],
    quantity: str,
    look: Look,
    *,
    mark: str = "",
    role: str = "",
) -> Trace:
    points = [(row.cpu_s, row.error.of(quantity)) for row in rows if row.error is not None]
    drawn_points = [
        (cpu_s, max(error, _MIN_DRAWN_ERROR)) for cpu_s, error in points if math.isfinite(error)
    ]
    x, y = np.array(drawn_points, dtype=float).reshape(-1, 2).T
    return Trace(name, x, y, look=look, ordered=False, mark=mark, role=role)

"""Chart of curves over two parameters."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from fivtui.charts import STRONG, Chart, Label, Sheet, Trace, axis_label, parameter_text
from fivtui.model import PARAMETERS
from fivtui.orbits.curves.events import EventKind

from .result import Boundary

# Width and height of a figure, inches.
_FIGURE_SIZE: Final = (4.8, 3.9)
# Colours and names of curves by kind of their points.
_COLOURS: Final = {"hopf": STRONG, "fold": "series-4", "touch": "series-1"}
# Markers of matplotlib for events: cusps, Bautin points and touches on curves of folds, folds on
# curves of touching cycles, and Bautin points on curves of Hopf points.
_EVENT_MARKERS: Final = {
    EventKind.CUSP: "D",
    EventKind.BAUTIN: "o",
    EventKind.TOUCH: "s",
    EventKind.FOLD: "^",
}
# Touching cycles are the first on their branch that reach y = 0, where the slider leaves the belt.
_CURVE_NAMES: Final = {
    "hopf": "Hopf points",
    "fold": "folds",
    "touch": Label("first touch of y = 0", "first touch of $y$ = 0"),
}
# Names of events that differ from their kinds: Bautin points are named after N. N. Bautin.
_EVENT_NAMES: Final = {EventKind.BAUTIN: "Bautin"}


def boundary_sheet(result: Boundary) -> Sheet:
    """The curves in the plane of the two parameters, with their events."""
    curves = [
        _trace(
            _CURVE_NAMES[result.kind] if index == 0 else "",
            (point.values for point in curve.points),
            colour=_COLOURS[result.kind],
        )
        for index, curve in enumerate(result.curves)
    ]
    events = [
        _trace(_EVENT_NAMES.get(kind, str(kind)), values, role="event", marker=marker)
        for kind, marker in _EVENT_MARKERS.items()
        if (values := [event.values for event in result.events if event.kind is kind])
    ]
    x_label, y_label = (axis_label(PARAMETERS[name]) for name in result.names)
    chart = Chart(x_label, y_label, (*curves, *events))
    title = parameter_text(result.parameters, result.names)
    return Sheet([[chart]], _FIGURE_SIZE, title)


def _trace(
    name: str,
    values: Iterable[tuple[float, float]],
    *,
    role: str = "",
    colour: str = "",
    marker: str = "",
) -> Trace:
    # Role and marker are the style in figures. Curves may turn back, so that x is not ordered.
    x, y = np.array(list(values), dtype=float).reshape(-1, 2).T
    return Trace(name, x, y, ordered=False, role=role, colour=colour, marker=marker)

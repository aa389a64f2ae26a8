"""Differences between the results of two runs. Imports no Textual."""

from operator import attrgetter
from typing import Final

import numpy as np

from fivtui.results import Row
from fivtui.transient import QUANTITY_ROWS, Transient

from .report import quantity_text
from .runs import engine_of

# Label, unit and attribute of the compared quantities.
_QUANTITIES: Final = (
    *QUANTITY_ROWS,
    ("separations", "", "events.separations"),
    ("time off the belt", "s", "events.separated_time"),
)


def percent_text(value: float, baseline: float) -> str:
    """The difference in percent of the baseline, for a narrow column; a dash if undefined."""
    if value == baseline:
        return "0"
    return f"{100.0 * (value - baseline) / abs(baseline):+.3g}" if baseline else "–"


def change_rows(run: Transient, baseline: Transient) -> list[Row]:
    """A row per quantity: the difference as value, baseline and percentage as note."""
    rows = []
    for label, unit, attribute in _QUANTITIES:
        value, reference = map(attrgetter(attribute), (run, baseline))
        difference = quantity_text(value - reference, unit)
        has_percentage = reference and value != reference
        percentage = f" ({percent_text(value, reference)} %)" if has_percentage else ""
        note = f"from {quantity_text(reference, unit)}{percentage}"
        rows.append(Row(label, f"{'+' if value > reference else ''}{difference}", note))
    return rows


def engine_difference_text(native: Transient, fmu: Transient) -> str:
    """Describe the differences between the FMU's and the native result of a scene."""
    # The greatest of the differences in m and in m/s: both show whether the engines agree.
    state_difference = float(np.abs(np.subtract(native.final, fmu.final)).max())
    peak_difference = abs(native.peak.y_abs - fmu.peak.y_abs)
    text = f"{engine_of(fmu.method)} against {native.method}: "
    text += f"final state {state_difference:.2g} (m, m/s), peak |y| {peak_difference:.2g} m"
    motion, fmu_motion = native.trajectory, fmu.trajectory
    if motion is not None and fmu_motion is not None and np.array_equal(motion.t, fmu_motion.t):
        text += f", y at any time {float(np.abs(motion.y - fmu_motion.y).max()):.2g} m"
    counts_equal = native.events.separations == fmu.events.separations
    counts = f"{native.events.separations} and {fmu.events.separations}"
    return f"{text}, separations {'equal' if counts_equal else counts}"

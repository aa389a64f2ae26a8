"""Differences between the results of two runs. Imports no Textual."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from fivtui.results import Row
from fivtui.transient import Transient

from .report import HALF_RANGE_LABEL, quantity_text
from .runs import engine_of

# Label, unit and value of the compared quantities.
_QUANTITIES: Final[tuple[tuple[str, str, Callable[[Transient], float]], ...]] = (
    ("peak |y|", "m", lambda run: run.peak.y_abs),
    ("peak |x|", "m", lambda run: run.peak.x_abs),
    (HALF_RANGE_LABEL, "m", lambda run: run.steady.y_half_range),
    ("contact force max", "N", lambda run: run.contact_force.max),
    ("separations", "", lambda run: float(run.events.separations)),
    ("time off the belt", "s", lambda run: run.events.separated_time),
    ("max ẋ", "m/s", lambda run: run.peak.vx_max),
    ("final x", "m", lambda run: run.final.x),
    ("final ẋ", "m/s", lambda run: run.final.vx),
    ("final y", "m", lambda run: run.final.y),
    ("final ẏ", "m/s", lambda run: run.final.vy),
)


@dataclass(frozen=True, slots=True)
class Change:
    """A quantity of a run and of its baseline."""

    label: str
    unit: str
    value: float
    baseline: float

    @property
    def difference(self) -> float:
        """Value minus baseline."""
        return self.value - self.baseline

    @property
    def percent(self) -> float | None:
        """The difference in percent of the baseline; None if the baseline is zero."""
        return 100.0 * self.difference / abs(self.baseline) if self.baseline else None


def changes(run: Transient, baseline: Transient) -> list[Change]:
    """The compared quantities, the most important first."""
    return [Change(label, unit, read(run), read(baseline)) for label, unit, read in _QUANTITIES]


def percent_text(change: Change) -> str:
    """The difference in percent for a narrow column; a dash if undefined."""
    percent = change.percent
    if percent is None:
        return "0" if change.difference == 0.0 else "–"
    return f"{percent:+.3g}" if percent else "0"


def change_rows(run: Transient, baseline: Transient) -> list[Row]:
    """A row per quantity: the difference as value, baseline and percentage as note."""
    rows = []
    for change in changes(run, baseline):
        percent = change.percent
        percent_suffix = f" ({percent:+.3g} %)" if percent else ""
        sign = "+" if change.difference > 0.0 else ""
        value = f"{sign}{quantity_text(change.difference, change.unit)}"
        note = f"from {quantity_text(change.baseline, change.unit)}{percent_suffix}"
        rows.append(Row(change.label, value, note))
    return rows


def engine_difference_text(native: Transient, fmu: Transient) -> str:
    """Describe the differences between the FMU's and the native result of a scene."""
    # The greatest of the differences in m and in m/s: both show whether the engines agree.
    state_difference = max(
        abs(getattr(native.final, name) - getattr(fmu.final, name))
        for name in ("x", "vx", "y", "vy")
    )
    peak_difference = abs(native.peak.y_abs - fmu.peak.y_abs)
    text = f"{engine_of(fmu.method)} against {native.method}: "
    text += f"final state {state_difference:.2g} (m, m/s), peak |y| {peak_difference:.2g} m"
    motion, fmu_motion = native.trajectory, fmu.trajectory
    if motion is not None and fmu_motion is not None and np.array_equal(motion.t, fmu_motion.t):
        text += f", y at any time {float(np.abs(motion.y - fmu_motion.y).max()):.2g} m"
    counts_equal = native.events.separations == fmu.events.separations
    counts = f"{native.events.separations} and {fmu.events.separations}"
    return f"{text}, separations {'equal' if counts_equal else counts}"

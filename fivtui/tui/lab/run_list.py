"""The list of runs with their peaks and differences.

The half range is half the peak-to-peak of y over the second half of a run. The base scene is the
default of the form; the baseline is the run with which the user compares others. The live curve
follows the edits; its ghost is the curve before the last edit.
"""

from collections.abc import Sequence
from itertools import compress
from typing import ClassVar, Final

from rich.text import Text
from textual import on
from textual.binding import Binding, BindingType
from textual.widgets import DataTable

from fivtui.tui.session import (
    Run,
    Session,
    base_scene,
    difference_text,
    percent_text,
    quantity_text,
)
from fivtui.tui.tabs import ListTable, RunActionRequested

_KEYS: Final = "⏎ load  Space overlay  b base  x delete"
_NO_RUNS: Final = "none yet: Run keeps one"
# Column of the difference to the baseline of the quantity in the column before it.
_DIFFERENCE: Final = "Δ %"
_COLUMNS: Final = (
    "run",
    "plot",
    "engine",
    "peak |y| (m)",
    _DIFFERENCE,
    "±y 2nd half (m)",
    _DIFFERENCE,
    "sep.",
    "off belt %",
    "changes",
)


class RunsTable(ListTable[str | Text]):
    """The runs, newest first, with their differences from the base scene and the baseline."""

    BORDER_TITLE = "Runs"

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(
            "enter", "request('load')", "Load", key_display="⏎", tooltip="Load the scene of the run"
        ),
        Binding("space", "request('overlay')", "Overlay", key_display="Space"),
        Binding("b", "request('baseline')", "Baseline", tooltip="Compare other runs with this one"),
        Binding("s", "request('show')", "Show"),
        Binding("x,delete", "request('delete')", "Delete", key_display="x"),
        Binding("c", "request('colour')", "Colour", show=False),
        Binding("m", "request('marker')", "Marker", show=False),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__(id="runs", omitted=("off belt %", "engine", "sep."))
        self._session = session
        # The numbers of the runs, and how they were plotted when they were last displayed.
        self._numbers: list[int] = []
        self._plot_marks: list[str] = []

    def action_request(self, action: str) -> None:
        """Request an action on the run at the cursor."""
        if self._numbers:
            self.post_message(RunActionRequested(self._numbers[self.cursor_row], action))

    def show(self) -> None:
        """Display the runs, and mark those that are plotted."""
        runs = list(self._session.runs)[::-1]
        current_number = self._numbers[self.cursor_row] if self._numbers else None
        self._numbers = [run.number for run in runs]
        self._plot_marks = self._marks()
        self.border_subtitle = _KEYS if runs else _NO_RUNS
        self.show_header = bool(runs)
        # Without a baseline, omit the differences.
        has_baseline = self._session.runs.baseline is not None
        is_shown = [label != _DIFFERENCE or has_baseline for label in _COLUMNS]
        rows = {str(run.number): list(compress(self._cells(run), is_shown)) for run in runs}
        self.fill(list(compress(_COLUMNS, is_shown)), rows)
        # Keep the cursor at its run, or in its row if the run was deleted.
        if current_number in self._numbers:
            self.move_cursor(row=self._numbers.index(current_number))

    def update_marks(self) -> None:
        """Update the display if the set of plotted runs has changed."""
        if self._plot_marks != self._marks():
            self.show()

    def _marks(self) -> list[str]:
        return [self._mark(run) for run in self._session.runs]

    @on(DataTable.RowSelected)
    def _show_selected(self, event: DataTable.RowSelected) -> None:
        # A mouse click selects a row; Enter loads the scene instead.
        event.stop()
        self.action_request("show")

    def _mark(self, run: Run) -> str:
        # How a run is plotted. The live curve replaces the displayed run, and its ghost, plotted as
        # "before", may be a run of the list.
        live = self._session.live
        if run is self._session.runs.displayed and not live.visible:
            return "shown"
        if run.overlaid:
            return "on"
        return "before" if live.visible and run.result is live.ghost else "off"

    def _cells(self, run: Run) -> Sequence[str | Text]:
        # The cells of a run in the order of `_COLUMNS`.
        marker, colour = run.look
        name = Text.assemble((marker, self.app.theme_variables[colour]), f" {run.number}")
        description = run.source or difference_text(run.scene, base_scene()) or "none"
        result, baseline = run.result, self._session.runs.baseline
        if result is None:
            return (name, "", run.engine, run.state.value, "", "", "", "", "", description)
        peak_change = half_range_change = "base" if baseline is run else ""
        if baseline is not None and baseline.result is not None and baseline is not run:
            reference = baseline.result
            peak_change = percent_text(result.peak.y_abs, reference.peak.y_abs)
            half_range_change = percent_text(
                result.steady.y_half_range, reference.steady.y_half_range
            )
        return (
            name,
            self._mark(run),
            run.engine,
            quantity_text(result.peak.y_abs),
            peak_change,
            quantity_text(result.steady.y_half_range),
            half_range_change,
            str(result.events.separations),
            f"{100.0 * result.events.separated_time / result.t_end:.3g}",
            description,
        )

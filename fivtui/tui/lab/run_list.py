"""The list of runs with their peaks and differences.

The half range is half the peak-to-peak of y over the second half of a run. The base scene is the
default of the form; the baseline is the run with which the user compares others. The live curve
follows the edits; its ghost is the curve before the last edit.
"""

from collections.abc import Mapping, Sequence
from itertools import compress
from typing import ClassVar, Final

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.coordinate import Coordinate
from textual.widgets import DataTable

from fivtui.tui.session import (
    Run,
    Session,
    base_scene,
    differences,
    percent_text,
    quantity_text,
)
from fivtui.tui.tabs import ListTable, RunActionRequested

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
    """A table with a row per run."""

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

    @property
    def number(self) -> int | None:
        """Number of the run at the cursor."""
        if not self.row_count:
            return None
        return int(str(self.coordinate_to_cell_key(Coordinate(self.cursor_row, 0)).row_key.value))

    def action_request(self, action: str) -> None:
        """Request an action on the run at the cursor."""
        if self.number is not None:
            self.post_message(RunActionRequested(self.number, action))


class RunsPane(Vertical):
    """The runs, newest first, with their differences from the base scene and the baseline."""

    BORDER_TITLE = "Runs"
    KEYS: ClassVar[str] = "⏎ load  Space overlay  b base  x delete"
    NO_RUNS: ClassVar[str] = "none yet: Run keeps one"

    def __init__(self, session: Session) -> None:
        super().__init__(id="runs")
        self._session = session
        self._plot_marks: list[str] = []

    def compose(self) -> ComposeResult:
        """The table."""
        yield RunsTable(omitted=("off belt %", "engine", "sep."))

    def show(self) -> None:
        """Display the runs, and mark those that are plotted."""
        session, runs = self._session, self._session.runs
        self._plot_marks = [_plot_mark(run, session) for run in runs]
        table = self.query_one(RunsTable)
        number, row = table.number, table.cursor_row
        newest_first = list(reversed(list(runs)))
        self.border_subtitle = self.KEYS if newest_first else self.NO_RUNS
        table.show_header = bool(newest_first)
        # Without a baseline, omit the differences.
        is_shown = [label != _DIFFERENCE or runs.baseline is not None for label in _COLUMNS]
        colours = self.app.theme_variables
        table.fill(
            list(compress(_COLUMNS, is_shown)),
            {
                str(run.number): list(compress(_cells(run, session, colours), is_shown))
                for run in newest_first
            },
        )
        # Keep the cursor at its run, or in its row if the run was deleted.
        numbers = [run.number for run in newest_first]
        table.move_cursor(
            row=numbers.index(number) if number in numbers else min(row, len(numbers) - 1)
        )

    def update_marks(self) -> None:
        """Update the display if the set of plotted runs has changed."""
        if self._plot_marks != [_plot_mark(run, self._session) for run in self._session.runs]:
            self.show()

    @on(DataTable.RowSelected)
    def _show_selected(self, event: DataTable.RowSelected) -> None:
        # A mouse click selects a row; Enter loads the scene instead.
        event.stop()
        self.post_message(RunActionRequested(int(str(event.row_key.value)), "show"))


def _plot_mark(run: Run, session: Session) -> str:
    # How a run is plotted. The live curve replaces the displayed run, and its ghost, plotted as
    # "before", may be a run of the list.
    live = session.live
    if run is session.runs.displayed and not live.visible:
        return "shown"
    if run.overlaid:
        return "on"
    return "before" if live.visible and run.result is live.ghost else "off"


def _cells(run: Run, session: Session, colours: Mapping[str, str]) -> Sequence[str | Text]:
    # The cells of a run in the order of `_COLUMNS`; `colours` are those of the theme by role.
    differing_fields = ", ".join(map(str, differences(run.scene, base_scene()))) or "none"
    name = Text.assemble((run.style.marker_sign, colours[run.style.colour_role]), f" {run.number}")
    description = run.source or differing_fields
    if run.result is None:
        return (name, "", run.engine, run.state.value, "", "", "", "", "", description)
    result, baseline, peak_change, half_range_change = run.result, session.runs.baseline, "", ""
    if baseline is run:
        peak_change = half_range_change = "base"
    elif baseline is not None and baseline.result is not None:
        reference = baseline.result
        peak_change = percent_text(result.peak.y_abs, reference.peak.y_abs)
        half_range_change = percent_text(result.steady.y_half_range, reference.steady.y_half_range)
    return (
        name,
        _plot_mark(run, session),
        run.engine,
        quantity_text(result.peak.y_abs),
        peak_change,
        quantity_text(result.steady.y_half_range),
        half_range_change,
        str(result.events.separations),
        f"{100.0 * result.events.separated_time / result.t_end:.3g}",
        description,
    )

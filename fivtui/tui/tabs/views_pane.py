"""A tab with several views, one visible at a time, and the cursors of their charts.

A view of a tab is a page of it; the `View` of a chart has its limits, scales and cursors.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.events import Resize
from textual.style import Style
from textual.widget import Widget
from textual.widgets import ContentSwitcher, Static

from fivtui.charts import Cursors, View, VisibleCharts, cursor_texts
from fivtui.tui.chart import ChartView, Control

from .pane import Pane
from .preview import Preview, Sketch
from .tables import flow_facts

# Short titles of views, for narrow windows, and columns of a border beside its titles.
_SHORT_TITLES: Final = {"Difference": "Diff", "Measured": "Meas"}
_CORNERS: Final = 6
# Styles of the titles of the current view and of the hidden ones.
_CURRENT_STYLE: Final = "reverse"
_HIDDEN_STYLE: Final = "not bold $foreground 80%"
_NOTE_STYLE: Final = "bold $text-warning"
# Class of a pane whose result is not that of the edited scene, and the note after its titles.
_OUTDATED: Final = "-outdated"
OUTDATED_NOTE: Final = "another scene"
# Note after the titles of a tab that computes with the values of tables over time at t = 0.
_AT_START_NOTE: Final = "at t = 0"
# Rows of each of several charts from which all can be shown, and from which all are shown at first.
_MIN_CHART_ROWS: Final = 5
_GOOD_CHART_ROWS: Final = 10
# Least columns of charts side by side.
_MIN_CHART_COLUMNS: Final = 40
# The key that shows another chart; a click on it does the same.
_NEXT_CHART: Final = Control("next_chart", "n: next chart", "n:next")
_ALL: Final = "all"
# Columns beside the values that cursors read.
_PADDING: Final = 2
_CURSOR_KEYS: Final = ("C: second cursor", "← →: move", "Esc: off")
# Separates the values that two cursors read.
_SEPARATOR: Final = "  "


class ViewsPane(Pane):
    """A pane whose upper border has the titles of its views."""

    # Identifier and title of every view; `compose_views` yields a page for each identifier.
    VIEWS: ClassVar[Mapping[str, str]] = {}
    # Key of the stored view.
    VIEW_SETTING: ClassVar[str] = "view"
    # Whether the tab computes with the values of tables over time at t = 0.
    AT_START: ClassVar[bool] = False
    # Shape of a typical result, displayed before the first result.
    SKETCH: ClassVar[Sketch | None] = None
    # A note on the views after their titles, if the border has room.
    title_note = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("v", "next_view", "View"),
        Binding("n", "next_chart", "Chart", tooltip="Next chart, or all charts"),
    ]

    def compose(self) -> ComposeResult:
        """The views, and the values that cursors read."""
        with ContentSwitcher(initial=self.page_of(self.view), classes="views"):
            yield from self.compose_views()
        if self.SKETCH is not None:
            yield Preview(self.SKETCH)
        yield Static("", classes="cursor-text", markup=False)

    def compose_views(self) -> ComposeResult:
        """The pages of the views."""
        raise NotImplementedError

    def page_of(self, view: str) -> str:
        """Identifier of the page that displays a view."""
        return view

    @on(Resize)
    def _fit_titles(self) -> None:
        self.show_titles()
        # The sizes of the parts follow that of the pane.
        self.call_after_refresh(self._refit_charts)
        if self.has_class("-cursors"):
            self._show_cursors()

    def _refit_charts(self) -> None:
        shown = [chart.display for chart in self.page.query(ChartView)]
        self.fit_charts()
        if shown != [chart.display for chart in self.page.query(ChartView)]:
            self.draw()

    def on_mount(self) -> None:
        """Restore limits and scales of the charts."""
        # Charts over the same quantity share their cursors.
        self.shared_cursors: dict[str, Cursors] = {}
        for chart in self.query(ChartView):
            chart.shared_cursors = self.shared_cursors
            chart.view = self.session.views.setdefault(str(chart.id), chart.view)

    @on(ChartView.LimitsChanged)
    def _link_limits(self, event: ChartView.LimitsChanged) -> None:
        # Charts one above the other have common limits of x.
        changed = event.chart_view
        for chart in changed.siblings if type(changed.parent) is Vertical else ():
            if isinstance(chart, ChartView):
                chart.view.x, chart.view.log_x = changed.view.x, changed.view.log_x
                # The heading of the chart warns of later runs that are outside the limits.
                chart.view.newest_run_when_zoomed = changed.view.newest_run_when_zoomed
                chart.redraw()

    @on(ChartView.CursorMoved)
    def _redraw_cursors(self, event: ChartView.CursorMoved) -> None:
        event.stop()
        cursors = event.chart_view.view.cursors
        for chart in self.query(ChartView):
            if chart is not event.chart_view and chart.view.cursors is cursors:
                chart.redraw()
        self._show_cursors()

    def _show_cursors(self) -> None:
        # The positions of both cursors of the current view, wrapped; with one cursor, its keys.
        phrases: list[str] = []
        for chart in self.shown_chart_views():
            label = "" if chart.chart is None else chart.chart.cursor_label
            cursors = chart.view.cursors
            # Cursors that are not pinned follow the pointer, not keys.
            if cursors.pinned:
                phrases = list(_CURSOR_KEYS)
            if label and cursors.first is not None and cursors.second is not None:
                phrases = cursor_texts(label, cursors.first[0], cursors.second[0])
            if phrases:
                break
        cursor_text = self.query_one(".cursor-text", Static)
        if phrases and not self.has_class("-cursors"):
            # The charts keep their height where the text replaces a summary.
            heights = [summary.size.height for summary in self.query("#summary")]
            cursor_text.styles.min_height = max(heights, default=1)
        self.set_class(bool(phrases), "-cursors")
        cursor_text.update(flow_facts(phrases, self.size.width - _PADDING, _SEPARATOR))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Whether an action is available: the next view and chart need several of them."""
        items = {"next_view": self.VIEWS, "next_chart": self._stacked_charts}
        return action not in items or len(items[action]) > 1

    def key_hints(self) -> list[str]:
        """Keys of the tab; the first focus the plot and show the next view."""
        keys = [f"{self.session.key_names['go-plot']} plot", *["v view"] * (len(self.VIEWS) > 1)]
        return [*keys, *super().key_hints()]

    def draw(self) -> None:
        """Draw the current view."""
        raise NotImplementedError

    @property
    def view(self) -> str:
        """Identifier of the current view; at first that of the first one."""
        stored = self.stored_setting(self.VIEW_SETTING, "")
        return stored if stored in self.VIEWS else next(iter(self.VIEWS))

    def mark_result(self, *, outdated: bool = False) -> None:
        """Dim and mark a result that is not of the edited scene, and note values at t = 0."""
        self.set_class(outdated, _OUTDATED)
        at_start = _AT_START_NOTE if self.AT_START and self.session.over_time else ""
        note = OUTDATED_NOTE if outdated else at_start
        if note != self.title_note:
            self.title_note = note
            self.show_titles()

    @property
    def page(self) -> Widget:
        """The page of the current view."""
        return self.query_one(f"#{self.page_of(self.view)}")

    def action_next_view(self) -> None:
        """Show the next view."""
        names = list(self.VIEWS)
        self.show_view(names[(names.index(self.view) + 1) % len(names)])

    def action_show_view(self, name: str) -> None:
        """Show a view whose title was clicked."""
        self.show_view(name)

    def shown_chart_views(self) -> list[ChartView]:
        """The widgets of the charts of the current view."""
        chart_views = self.page.query(ChartView)
        return [chart for chart in chart_views if chart.chart is not None and chart.display]

    def visible_charts(self) -> VisibleCharts | None:
        """The visible charts of the current view; None if it has no chart."""
        panels = [
            (chart.chart, _copy_view(chart.view))
            for chart in self.shown_chart_views()
            if chart.chart is not None
        ]
        is_row = isinstance(self.page, Horizontal)
        return VisibleCharts(panels, side_by_side=is_row) if panels else None

    def fit_axes(self) -> None:
        """Fit the axes: the limits were chosen for an earlier result, or another quantity."""
        for chart in self.query(ChartView):
            chart.view.reset()

    def reset_charts(self) -> None:
        """Show the whole of another result, with all traces."""
        self.fit_axes()
        for chart in self.query(ChartView):
            chart.view.hidden.clear()

    # Several charts in a page

    @property
    def _stacked_charts(self) -> list[ChartView]:
        # The charts of the page; empty if they are side by side.
        is_row = self.page.layout.name == "horizontal"
        return [] if is_row else list(self.page.query(ChartView))

    def fit_charts(self) -> None:
        """Show the chosen chart of the page, or all charts if they have enough rows or columns."""
        page_charts, stacked = list(self.page.query(ChartView)), self._stacked_charts
        shown = page_charts[
            : max(self.query_one(ContentSwitcher).size.width // _MIN_CHART_COLUMNS, 1)
        ]
        if stacked:
            rows = self._chart_rows
            default = _ALL if rows >= _GOOD_CHART_ROWS else ""
            choice = self.stored_setting(self._choice_setting, default)
            shows_all = choice == _ALL and rows >= _MIN_CHART_ROWS
            chosen = [chart for chart in stacked if shows_all or chart.id == choice]
            shown = chosen or stacked[:1]
        for chart in page_charts:
            chart.extra_controls = (_NEXT_CHART,) if len(stacked) > 1 else ()
            chart.display = chart in shown
            if chart in shown:
                # Rules of a style sheet may still hide it.
                chart.styles.inline.clear_rule("display")

    @property
    def _chart_rows(self) -> int:
        # Rows of each chart if all are shown; whatever is beside them has one row.
        rows = self.query_one(ContentSwitcher).size.height
        rows -= sum(part.display and not isinstance(part, ChartView) for part in self.page.children)
        return rows // len(self._stacked_charts)

    @property
    def _choice_setting(self) -> str:
        return f"chart-{self.page.id}"

    def action_next_chart(self) -> None:
        """Show the next chart of the page, or all charts if they fit."""
        charts = self._stacked_charts
        choices = [str(chart.id) for chart in charts]
        shown = [str(chart.id) for chart in charts if chart.display]
        index = choices.index(shown[0]) if len(shown) == 1 else -1
        if index >= 0 and self._chart_rows >= _MIN_CHART_ROWS:
            choices.append(_ALL)
        self.store_setting(self._choice_setting, choices[(index + 1) % len(choices)])
        self.fit_charts()
        self.draw()
        if self.screen.focused in charts:
            self.focus_content(self.page)

    def show_view(self, name: str) -> None:
        """Show a view by its identifier."""
        self.store_setting(self.VIEW_SETTING, name)
        self.query_one(ContentSwitcher).current = self.page_of(name)
        self.show_titles()
        self.fit_charts()
        self.draw()
        self._show_cursors()
        self.focus_content(self.page)

    def show_titles(self) -> None:
        """Display the titles in the upper border, the current one marked."""
        width, titles = self.outer_size.width - _CORNERS, dict(self.VIEWS)
        if len(" ".join(titles.values())) >= width:
            titles = {name: _SHORT_TITLES.get(title, title) for name, title in titles.items()}
        blanks = "  " if len("  ".join(titles.values())) < width - 1 else " "
        styled_titles = []
        for name, title in titles.items():
            style = _CURRENT_STYLE if name == self.view else _HIDDEN_STYLE
            content = Content.styled(title, style if len(titles) > 1 else "")
            click = Style.from_meta({"@click": f"show_view('{name}')"})
            styled_titles.append(content.stylize(click))
        if self.title_note and len(blanks.join([*titles.values(), self.title_note])) < width:
            styled_titles.append(Content.styled(self.title_note, _NOTE_STYLE))
        self.border_title = Content(blanks).join(styled_titles)


def _copy_view(view: View) -> View:
    # Copy a view without cursors that follow the pointer.
    cursors = replace(view.cursors) if view.cursors.pinned else Cursors()
    return replace(view, hidden=set(view.hidden), cursors=cursors)

"""A tab with several views, one visible at a time, and the cursors of their charts.

A view of a tab is a page of it; the `View` of a chart has its limits, scales and cursors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Button, ContentSwitcher, Static

from fivtui.charts import Cursors, View, VisibleCharts, cursor_texts
from fivtui.tui.chart import ChartView

from .pane import Pane

# Identifiers of the buttons are this and the identifier of the view.
_PREFIX: Final = "view-"
# Key of the stored view.
_VIEW_SETTING: Final = "view"
# Columns of a button outside its title, and short titles for narrow windows.
_PADDING: Final = 2
_SHORT_TITLES: Final = {"Difference": "Diff", "Eigenvalues": "Eigenv."}
_CURSOR_KEYS: Final = ("C: second cursor", "← →: move", "Esc: off")
# Separates the values that two cursors read.
_SEPARATOR: Final = "  "


class ViewsPane(Pane):
    """A bar of buttons above the chosen view.

    Attributes
    ----------
    VIEWS : mapping of str to str
        Identifier and title of every view; `compose_views` yields a widget for each identifier.
    LOG_AXES : mapping of str to str
        Axes of charts that are logarithmic at first, such as ``xy``.
    COMMON_X_LIMITS : sequence of sequences of str
        Groups of identifiers of charts with common limits of x.
    """

    VIEWS: ClassVar[Mapping[str, str]] = {}
    LOG_AXES: ClassVar[Mapping[str, str]] = {}
    COMMON_X_LIMITS: ClassVar[Sequence[Sequence[str]]] = ()
    BINDINGS: ClassVar[list[BindingType]] = [Binding("v", "next_view", "View")]

    def compose(self) -> ComposeResult:
        """The bar and the views."""
        with Horizontal(classes="bar"):
            for name, title in self.VIEWS.items() if len(self.VIEWS) > 1 else ():
                yield Button(title, id=f"{_PREFIX}{name}", classes="view-button", compact=True)
            yield from self.compose_bar()
        stored, first = self.stored_setting(_VIEW_SETTING, ""), next(iter(self.VIEWS))
        with ContentSwitcher(initial=stored if stored in self.VIEWS else first, classes="views"):
            yield from self.compose_views()
        yield Static("", classes="cursor-text", markup=False)

    def compose_bar(self) -> ComposeResult:
        """Further widgets in the bar."""
        yield from ()

    def compose_views(self) -> ComposeResult:
        """The views."""
        raise NotImplementedError

    def on_resize(self, event: Resize) -> None:
        """Shorten titles that do not fit, and wrap the values that cursors read."""
        is_narrow = sum(len(title) + _PADDING for title in self.VIEWS.values()) > event.size.width
        for button in self.query(".view-button").results(Button):
            title = self.VIEWS[str(button.id).removeprefix(_PREFIX)]
            button.label = _SHORT_TITLES.get(title, title) if is_narrow else title
            # Without this call a displayed button would keep its width.
            button.refresh(layout=True)
        if self.has_class("-cursors"):
            self._show_cursors()

    def on_mount(self) -> None:
        """Mark the current view and restore limits and scales of the charts."""
        self._mark_button()
        # Charts over the same quantity share their cursors.
        self.shared_cursors: dict[str, Cursors] = {}
        for chart in self.query(ChartView):
            chart.shared_cursors = self.shared_cursors
            name = str(chart.id)
            if name not in self.session.views:
                log_axes = self.LOG_AXES.get(name, "")
                self.session.views[name] = View(log_x="x" in log_axes, log_y="y" in log_axes)
            chart.view = self.session.views[name]

    @on(ChartView.LimitsChanged)
    def _link_limits(self, event: ChartView.LimitsChanged) -> None:
        changed_view = event.chart_view.view
        groups = (group for group in self.COMMON_X_LIMITS if event.chart_view.id in group)
        for chart in (self.query_one(f"#{name}", ChartView) for name in next(groups, ())):
            if chart is not event.chart_view:
                chart.view.x, chart.view.log_x = changed_view.x, changed_view.log_x
                # The heading of the chart warns of later runs that are outside the limits.
                chart.view.newest_run_when_zoomed = changed_view.newest_run_when_zoomed
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
        self.set_class(bool(phrases), "-cursors")
        lines: list[str] = []
        for phrase in phrases:
            longer_line = f"{lines[-1]}{_SEPARATOR}{phrase}" if lines else ""
            if lines and len(longer_line) <= self.size.width - _PADDING:
                lines[-1] = longer_line
            else:
                lines.append(phrase)
        self.query_one(".cursor-text", Static).update("\n".join(lines))

    def theme_changed(self) -> None:
        """Redraw the charts in the new colours."""
        for chart in self.query(ChartView):
            chart.redraw()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Whether an action is available: the next view needs several views."""
        return action != "next_view" or len(self.VIEWS) > 1

    def key_hints(self) -> list[str]:
        """Keys of the tab; the first focus the plot and show the next view."""
        keys = ["Alt+P plot", "v view"] if len(self.VIEWS) > 1 else ["Alt+P plot"]
        return [*keys, *super().key_hints()]

    def draw(self) -> None:
        """Draw the current view."""
        raise NotImplementedError

    @property
    def view_switcher(self) -> Widget:
        """The container of the views."""
        return self.query_one(ContentSwitcher)

    @property
    def view(self) -> str:
        """Identifier of the current view."""
        return str(self.query_one(ContentSwitcher).current)

    def action_next_view(self) -> None:
        """Show the next view."""
        names = list(self.VIEWS)
        self.show_view(names[(names.index(self.view) + 1) % len(names)])

    def shown_chart_views(self) -> list[ChartView]:
        """The widgets of the charts of the current view."""
        chart_views = self.query_one(f"#{self.view}").query(ChartView)
        return [chart for chart in chart_views if chart.chart is not None and chart.display]

    def visible_charts(self) -> VisibleCharts | None:
        """The visible charts of the current view; None if it has no chart."""
        box = self.query_one(f"#{self.view}")
        panels = [
            (chart.chart, _copy_view(chart.view))
            for chart in self.shown_chart_views()
            if chart.chart is not None
        ]
        return VisibleCharts(panels, side_by_side=isinstance(box, Horizontal)) if panels else None

    @on(Button.Pressed, ".view-button")
    def _show_pressed_view(self, event: Button.Pressed) -> None:
        event.stop()
        self.show_view(str(event.button.id).removeprefix(_PREFIX))

    def show_view(self, name: str) -> None:
        """Show a view by its identifier."""
        self.query_one(ContentSwitcher).current = name
        self.store_setting(_VIEW_SETTING, name)
        self._mark_button()
        self.draw()
        self._show_cursors()
        self.focus_within(self.query_one(f"#{name}"))

    def _mark_button(self) -> None:
        for button in self.query(".view-button"):
            button.set_class(button.id == f"{_PREFIX}{self.view}", "-active")


def _copy_view(view: View) -> View:
    # Copy a view without cursors that follow the pointer.
    cursors = replace(view.cursors) if view.cursors.pinned else Cursors()
    return replace(view, hidden=set(view.hidden), cursors=cursors)

"""The widget that shows a chart."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

from rich.segment import Segment
from rich.style import Style
from textual.binding import Binding, BindingType
from textual.events import (
    Click,
    Leave,
    MouseDown,
    MouseMove,
    MouseScrollDown,
    MouseScrollUp,
    MouseUp,
)
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

from fivtui.tui.chart.chart import Chart, Cursors, Place, Trace, View
from fivtui.tui.chart.picture import MARGIN, Picture, draw
from fivtui.tui.chart.reading import (
    NearestPoint,
    Span,
    is_long,
    nearest,
    nearest_along,
    nearest_index,
)
from fivtui.tui.chart.styles import CHART_STYLES, FOCUSED_STYLES

from .limits_dialog import LimitsDialog

_ZOOM: Final = Binding.Group("Zoom")
_PAN: Final = Binding.Group("Pan")
_ZOOM_STEP: Final = 0.7
_WHEEL_STEP: Final = 0.85
_PAN_STEP: Final = 0.15
_BIG_STEP: Final = 10
# Steps of a cursor along a whole curve, and where cursors appear.
_STEPS: Final = 500
_APPEAR: Final = (0.5, 0.75)
_RIGHT_BUTTON: Final = 3
_WIDE: Final = 90
_LEAST: Final = (MARGIN + 2, 3)


@dataclass(frozen=True, slots=True)
class _Control:
    # A clickable word at the end of the heading, with a short form for narrow charts.
    action: str
    words: str
    brief: str


_CONTROLS: Final = (
    _Control("log('x')", "log x", "logx"),
    _Control("log('y')", "log y", "logy"),
    _Control("limits", "limits", "lim"),
    _Control("whole", "fit", "fit"),
)


class ChartView(Widget, can_focus=True):
    """A chart with zoom, pan, cursor, typed limits and logarithmic axes, by key and mouse.

    textual-plot takes over 50 ms per plot and has no logarithmic axes, cursor or shades.

    Parameters
    ----------
    id : str
        Identifier of the widget.
    nothing : str
        Text in place of a chart.
    openable : bool
        Whether Enter and a double click open a point (`Opened`).
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("plus,equals_sign", "zoom(-1)", "Zoom in", key_display="+", group=_ZOOM),
        Binding("minus", "zoom(1)", "Zoom out", key_display="-", group=_ZOOM),
        Binding("shift+up,K", "zoom_y(-1)", "Zoom in along y", show=False),
        Binding("shift+down,J", "zoom_y(1)", "Zoom out along y", show=False),
        Binding("left,h", "step(-1, 0)", "Left", key_display="←", group=_PAN),
        Binding("right,l", "step(1, 0)", "Right", key_display="→", group=_PAN),
        Binding("up,k", "step(0, 1)", "Up", show=False),
        Binding("down,j", "step(0, -1)", "Down", show=False),
        Binding("shift+left,H", f"step(-{_BIG_STEP}, 0)", "Far left", show=False),
        Binding("shift+right,L", f"step({_BIG_STEP}, 0)", "Far right", show=False),
        Binding("r", "whole", "Fit"),
        Binding("c", "cursor(0)", "Cursor", tooltip="First cursor: on, move, off"),
        Binding("C", "cursor(1)", "Second cursor: on, move, off", show=False),
        Binding("escape", "cursor_off", "Cursors off", show=False),
        Binding("enter", "open", "Open", key_display="⏎", tooltip="Run the point at the cursor"),
        Binding("g", "limits", "Limits"),
        Binding("x", "log('x')", "Log x", show=False),
        Binding("y", "log('y')", "Log y", show=False),
        *(
            Binding(str(number), f"trace({number})", f"Trace {number}", show=False)
            for number in range(1, 10)
        ),
    ]

    @dataclass
    class Opened(Message):
        """Posted when a point is opened."""

        view: "ChartView"
        point: NearestPoint

        @property
        def control(self) -> "ChartView":
            """The chart, for ``@on`` selectors."""
            return self.view

    @dataclass
    class Moved(Message):
        """Posted when the visible part has changed."""

        view: "ChartView"

        @property
        def control(self) -> "ChartView":
            """The chart, for ``@on`` selectors."""
            return self.view

    @dataclass
    class CursorMoved(Message):
        """Posted when a cursor was placed, moved or removed."""

        view: "ChartView"

        @property
        def control(self) -> "ChartView":
            """The chart, for ``@on`` selectors."""
            return self.view

    def __init__(self, id: str, *, nothing: str = "", openable: bool = False) -> None:  # noqa: A002
        super().__init__(id=id)
        self.view = View()
        self._chart: Chart | None = None
        self._nothing, self._openable = nothing, openable
        self._picture: Picture | None = None
        self._styles_by_name: dict[str, Style] = {}
        self._controls: list[tuple[int, int, str]] = []
        self._held: tuple[int, int] | None = None
        self._dragged = False
        # Cursors by what they are at a value of, which charts share, or by chart.
        self.linked: dict[str, Cursors] = {}

    @property
    def chart(self) -> Chart | None:
        """The displayed chart."""
        return self._chart

    def text(self) -> str:
        """The picture without its styles; empty without a chart."""
        if self._chart is None:
            return ""
        return draw(self._chart, self.view, *self.size).text()

    def show(self, chart: Chart | None, *, nothing: str | None = None) -> None:
        """Display a chart in the current view; if None, the text `nothing`."""
        self._chart = chart
        if chart is not None:
            shared = chart.cursor_label or str(self.id)
            self.view.cursors = self.linked.setdefault(shared, Cursors())
        if nothing is not None:
            self._nothing = nothing
        self.redraw()

    def redraw(self) -> None:
        """Draw the chart again."""
        self._picture = None
        self.refresh()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Disable "open" where points cannot be opened."""
        return self._openable if action == "open" else True

    # Drawing

    def notify_style_update(self) -> None:
        """Follow a change of theme."""
        self._styles_by_name.clear()
        super().notify_style_update()

    def _style(self, name: str) -> Style:
        if name not in self._styles_by_name:
            known = {**CHART_STYLES, **(FOCUSED_STYLES if self.has_focus else {})}
            own = self.app.stylesheet.parse_style(known.get(name, name))
            self._styles_by_name[name] = (self.visual_style + own).rich_style
        return self._styles_by_name[name]

    def on_focus(self) -> None:
        """Use the styles of a focused chart."""
        self._restyle()

    def on_blur(self) -> None:
        """Use the usual styles."""
        self._restyle()

    def _restyle(self) -> None:
        self._styles_by_name.clear()
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """A line of the picture."""
        lines = self._lines()
        spans = lines[y] if y < len(lines) else []
        width = self.size.width
        segments = [Segment(text, self._style(name)) for text, name in spans]
        return Strip(segments).adjust_cell_length(width, self._style("plot"))

    def _lines(self) -> list[list[Span]]:
        width, height = self.size
        if self._chart is None or width < _LEAST[0] or height < _LEAST[1]:
            return [[("", "plot")], [(f" {self._nothing}"[:width], "label")]]
        if self._picture is None:
            self._controls.clear()
            crowded = width < _WIDE and is_long(self._chart, self.view)
            controls = [] if crowded else self._heading_end(width)
            reserved = sum(len(text) for text, _ in controls)
            self._picture = draw(self._chart, self.view, width, height, reserved=reserved)
            # The last span of the first line is the reserved room.
            self._picture.lines[0][-1:] = controls
        return self._picture.lines

    def _drawn(self) -> Picture | None:
        # Keys and mouse may come before the frame; without a chart or room there is no picture.
        self._lines()
        return self._picture

    def _heading_end(self, width: int) -> list[Span]:
        wide = width >= _WIDE
        words = [control.words if wide else control.brief for control in _CONTROLS]
        view = self.view
        kept = view.x is not None or view.y is not None
        on = {"log('x')": view.log_x, "log('y')": view.log_y, "whole": kept}
        column = width - sum(len(word) + 1 for word in words)
        spans: list[Span] = []
        for control, word in zip(_CONTROLS, words, strict=True):
            style = "control-on" if on.get(control.action) else "control"
            spans += [(" ", "plot"), (word, style)]
            self._controls.append((column + 1, column + 1 + len(word), control.action))
            column += len(word) + 1
        return spans

    def on_resize(self) -> None:
        """Draw for the new size."""
        self.redraw()

    # Moving

    def _moved(self) -> None:
        self.redraw()
        self.post_message(self.Moved(self))

    def action_zoom(self, direction: int) -> None:
        """Zoom in (-1) or out (+1) about the cursor, or else the middle."""
        self._zoom(_ZOOM_STEP, direction, self._cursor_place() or (0.5, 0.5))

    def _zoom(self, step: float, direction: int, about: tuple[float, float]) -> None:
        if self._chart is not None:
            self.view.zoom(self._chart, step**-direction, about)
            self._moved()

    def action_zoom_y(self, direction: int) -> None:
        """Zoom in (-1) or out (+1) along y alone."""
        if self._chart is not None:
            self.view.zoom_y(self._chart, _ZOOM_STEP**-direction)
            self._moved()

    def action_step(self, right: int, up: int) -> None:
        """Move the cursor if it is on, else pan."""
        if self._chart is None:
            return
        if self.view.cursors.kept:
            self._step_cursor(right, up)
        else:
            self.view.pan(self._chart, _PAN_STEP * right, _PAN_STEP * up)
            self._moved()

    def action_whole(self) -> None:
        """Fit both axes to the data."""
        self.view.reset()
        self._moved()

    def action_log(self, axis: str) -> None:
        """Switch an axis between linear and logarithmic."""
        self.view.toggle_log(x=axis == "x")
        self._moved()

    def action_trace(self, number: int) -> None:
        """Hide or show a trace."""
        if self._chart is not None and self.view.toggle_trace(self._chart, number - 1):
            self.redraw()

    def action_limits(self) -> None:
        """Ask for axis limits."""
        if self._chart is None:
            return

        def take(limits: "View | None") -> None:
            if limits is not None and self._chart is not None:
                self.view.choose(self._chart, limits.x, limits.y)
                self._moved()

        self.app.push_screen(LimitsDialog(self._chart, self.view), take)

    # The cursors

    def action_cursor(self, which: int) -> None:
        """Switch a cursor on, let keys move it if they move the other one, or switch it off."""
        cursors = self.view.cursors
        second = bool(which)
        before = cursors.second if second else cursors.first
        if self._chart is None:
            return
        if cursors.kept and before is not None and cursors.second_moves is second:
            cursors.put(None)
            cursors.second_moves = cursors.second is not None
            cursors.kept = cursors.moving is not None
            self._cursor_moved()
            return
        cursors.kept = True
        for number in (0, 1)[: which + 1]:
            cursors.second_moves = bool(number)
            if cursors.moving is None:
                self._appear(_APPEAR[number])
        cursors.second_moves = second
        self._cursor_moved()

    def _appear(self, part: float) -> None:
        trace = self._top_along()
        if trace is None:
            self._put_cursor((part, 0.5))
        elif trace.along is not None:
            self.view.cursors.put((float(trace.along[int(part * (trace.along.size - 1))]), 0.0))

    def action_cursor_off(self) -> None:
        """Switch the cursors off."""
        self.view.cursors.clear()
        self._cursor_moved()

    def _cursor_moved(self) -> None:
        self.redraw()
        self.post_message(self.CursorMoved(self))

    def _top_along(self) -> Trace | None:
        # The curve that keys move a cursor along.
        if self._chart is None or not self._chart.along:
            return None
        curves = [trace for _, trace in self.view.visible(self._chart) if trace.along is not None]
        return curves[-1] if curves and curves[-1].x.size else None

    def _cursor_place(self) -> Place | None:
        where = self.view.cursors.moving
        if self._chart is None or where is None:
            return None
        if self._chart.along:
            found = nearest(self._chart, self.view, where)
            if not found:
                return None
            where = (found[-1].x, found[-1].y)
        x, y = self.view.axes(self._chart)
        return float(x.place([where[0]])[0]), float(y.place([where[1]])[0])

    def _put_cursor(self, place: Place, direction: int = 0) -> None:
        if self._chart is None:
            return
        x, y = self.view.axes(self._chart)
        where = (x.value(place[0]), y.value(place[1]))
        if self._chart.along:
            at = nearest_along(self._chart, self.view, where)
            if at is None:
                return
            where = (at, 0.0)
        elif not self._chart.plane:
            where = (self._sampled(where[0], direction), where[1])
        self.view.cursors.put(where)
        self._cursor_moved()

    def _sampled(self, x: float, direction: int) -> float:
        # The nearest sample of the topmost trace; in a direction at least the next one.
        if self._chart is None:
            return x
        traces = [trace for _, trace in self.view.visible(self._chart) if trace.x.size]
        if not traces:
            return x
        values, before = traces[-1].x, self.view.cursors.moving
        at = nearest_index(values, x)
        if direction and before is not None and float(values[at]) == before[0]:
            at = min(max(at + (1 if direction > 0 else -1), 0), values.size - 1)
        return float(values[at])

    def _step_cursor(self, right: int, up: int) -> None:
        trace = self._top_along()
        if trace is not None:
            self._step_along(trace, right)
            return
        place, picture = self._cursor_place(), self._drawn()
        if place is None or picture is None or self._chart is None:
            return
        _, _, columns, rows = picture.plot
        across, along = place[0] + right / columns, place[1] + up / rows
        if not 0.0 <= across <= 1.0:
            # Pan so that the cursor stays visible.
            self.view.pan(self._chart, right / columns)
            self._moved()
        self._put_cursor((min(max(across, 0.0), 1.0), min(max(along, 0.0), 1.0)), right)

    def _step_along(self, trace: Trace, right: int) -> None:
        where = self.view.cursors.moving
        if trace.along is not None and where is not None:
            step = right * max(trace.along.size // _STEPS, 1)
            at = nearest_index(trace.along, where[0]) + step
            at = min(max(at, 0), trace.along.size - 1)
            self.view.cursors.put((float(trace.along[at]), 0.0))
            self._cursor_moved()

    def action_open(self) -> None:
        """Open the point nearest to the cursor; if there is none, switch it on."""
        if self._chart is None:
            return
        if self.view.cursors.moving is None:
            self.action_cursor(0)
            return
        found = nearest(self._chart, self.view, self.view.cursors.moving)
        if found:
            self.post_message(self.Opened(self, found[0]))

    # The mouse

    def on_mouse_move(self, event: MouseMove) -> None:
        """Pan while dragging, else move the read-out."""
        picture = self._drawn()
        if picture is None or self._chart is None:
            return
        _, _, columns, rows = picture.plot
        if self._held is not None:
            right, down = event.x - self._held[0], event.y - self._held[1]
            if right or down:
                self._held, self._dragged = (event.x, event.y), True
                follows = not self._chart.plane and self.view.y is None
                self.view.pan(self._chart, -right / columns, 0.0 if follows else down / rows)
                self._moved()
        elif not self.view.cursors.kept:
            place = picture.place(event.x, event.y)
            if all(0.0 <= part <= 1.0 for part in place):
                self._put_cursor(place)
            elif self.view.cursors.moving is not None:
                self.action_cursor_off()

    def on_leave(self, event: Leave) -> None:
        """Hide the read-out."""
        cursors = self.view.cursors
        if event.node is self and not cursors.kept and cursors.moving is not None:
            self.action_cursor_off()

    def on_mouse_down(self, event: MouseDown) -> None:
        """Start dragging."""
        self._dragged = False
        picture = self._drawn()
        if picture is not None and event.y >= picture.plot[1]:
            self._held = (event.x, event.y)
            self.capture_mouse()

    def on_mouse_up(self, _event: MouseUp) -> None:
        """End dragging."""
        self._held = None
        self.release_mouse()

    def on_mouse_scroll_up(self, event: MouseScrollUp) -> None:
        """Zoom in at the pointer."""
        self._wheel(event, -1)

    def on_mouse_scroll_down(self, event: MouseScrollDown) -> None:
        """Zoom out at the pointer."""
        self._wheel(event, 1)

    def _wheel(self, event: MouseScrollUp | MouseScrollDown, direction: int) -> None:
        picture = self._drawn()
        if picture is not None:
            event.stop()
            self._zoom(_WHEEL_STEP, direction, picture.place(event.x, event.y))

    async def on_click(self, event: Click) -> None:
        """Press a control, toggle a trace, place a cursor, or open a point (double click).

        The right button places the second cursor.
        """
        picture = self._drawn()
        if picture is None or self._dragged:
            return
        if event.y < picture.plot[1]:
            for first, stop, action in self._controls:
                if event.y == 0 and first <= event.x < stop:
                    await self.run_action(action)
                    return
            index = _legend_index(picture.lines[event.y], event.x)
            if index is not None:
                self.action_trace(index + 1)
            return
        place = picture.place(event.x, event.y)
        if not all(0.0 <= part <= 1.0 for part in place):
            return
        cursors = self.view.cursors
        second = event.button == _RIGHT_BUTTON
        if second and not cursors.kept:
            # The first one has followed the pointer to here.
            cursors.first = None
            self.action_cursor(0)
        cursors.kept, cursors.second_moves = True, second
        self._put_cursor(place)
        if event.chain == 2 and self._openable:
            self.action_open()


def _legend_index(spans: Sequence[Span], column: int) -> int | None:
    # A legend entry begins with a blank and the number of its trace.
    end = 0
    for text, style in spans:
        end += len(text)
        if column < end:
            entry = style == "hidden" or style.startswith(("trace-", "#"))
            return int(text[1]) - 1 if entry and text[1:2].isdigit() else None
    return None

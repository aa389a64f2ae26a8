"""The widget of a chart that keys and mouse zoom, pan and read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

from textual import events, on
from textual.binding import Binding, BindingType
from textual.message import Message

from fivtui.charts import Axis, NearestPoint, Position, points_at
from fivtui.tui.chart.cursor_moves import cursor_position, move_cursor, step_cursor, switch_cursor

from .drawn_chart import DrawnChart
from .limits_dialog import LimitsDialog

# Factors by which a key and the wheel change the visible part.
_ZOOM_FACTOR: Final = 0.7
_WHEEL_FACTOR: Final = 0.85
# Part of the visible range by which a key pans.
_PAN_SHARE: Final = 0.15
# Number of steps of a key with Shift.
_FAR_STEPS: Final = 10
# Textual's number of the right mouse button.
_RIGHT_BUTTON: Final = 3


@dataclass
class ChartMessage(Message):
    """A message of a chart."""

    chart_view: "ChartView"


class ChartView(DrawnChart, can_focus=True):
    """A chart with zoom, pan, cursors, typed limits and logarithmic axes, by key and mouse.

    In a chart with `runs_points`, such as that of growth rates over a parameter, points stand for
    parameter sets. Opening a point runs its parameters. The axes in `log` are logarithmic at first.

    The package textual-plot would take over 50 ms per plot, without log axes, cursors or shades.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("plus,equals_sign", "zoom(-1)", "Zoom", key_display="+ -", tooltip="Zoom in"),
        Binding("minus", "zoom(1)", "Zoom out", show=False),
        Binding("shift+up,K", "zoom_y(-1)", "Zoom in along y", show=False),
        Binding("shift+down,J", "zoom_y(1)", "Zoom out along y", show=False),
        Binding("left,h", "step(-1, 0)", "Pan", key_display="← →", tooltip="Left"),
        Binding("right,l", "step(1, 0)", "Right", show=False),
        Binding("up,k", "step(0, 1)", "Up", show=False),
        Binding("down,j", "step(0, -1)", "Down", show=False),
        Binding("shift+left,H", f"step(-{_FAR_STEPS}, 0)", "Far left", show=False),
        Binding("shift+right,L", f"step({_FAR_STEPS}, 0)", "Far right", show=False),
        Binding("g,home", "show_end(False)", "Start", show=False),
        Binding("G,end", "show_end(True)", "End", show=False),
        Binding("ctrl+d,pagedown", "half_page(1)", "Half a window on", show=False),
        Binding("ctrl+u,pageup", "half_page(-1)", "Half a window back", show=False),
        Binding("r", "fit", "Fit", tooltip="Fit the axes"),
        Binding("c", "cursor(0)", "Cursor", tooltip="First cursor: on, move, off"),
        Binding("C", "cursor(1)", "Second cursor: on, move, off", show=False),
        Binding("escape", "cursor_off", "Cursors off", show=False),
        Binding("enter", "open", "Open", key_display="⏎", tooltip="Run the point at the cursor"),
        Binding("i", "limits", "Limits", tooltip="Limits of the axes…"),
        Binding("x", "log('x')", "Logarithmic x axis", show=False),
        Binding("y", "log('y')", "Logarithmic y axis", show=False),
        *(
            Binding(str(number), f"trace({number})", f"Trace {number}", show=False)
            for number in range(1, 10)
        ),
    ]

    @dataclass
    class PointChosen(Message):
        """Posted when the user opens a point, to run its parameters."""

        point: NearestPoint

    class LimitsChanged(ChartMessage):
        """Posted when the limits or scales of the axes have changed."""

    class CursorMoved(ChartMessage):
        """Posted when a cursor was placed, moved or removed."""

    def __init__(
        self,
        id: str,  # noqa: A002
        *,
        empty_text: str = "",
        runs_points: bool = False,
        log: str = "",
    ) -> None:
        super().__init__(id, empty_text=empty_text)
        self.view.log_x, self.view.log_y = "x" in log, "y" in log
        self._runs_points = runs_points
        # Last column and row of the pointer while the mouse is dragged.
        self._drag_position: tuple[int, int] | None = None
        self._was_dragged = False

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:  # noqa: ARG002
        """Disable all without chart, "open" where points cannot be opened, "show_end" in planes."""
        is_allowed = {"open": self._runs_points, "show_end": not self._chart.is_plane}
        return self.chart is not None and is_allowed.get(action, True)

    # Zoom and pan

    def _handle_new_limits(self) -> None:
        self.redraw()
        self.post_message(self.LimitsChanged(self))

    def action_zoom(self, direction: int) -> None:
        """Zoom in (-1) or out (+1) about the cursor, without cursor about the middle."""
        centre = cursor_position(self._chart, self.view) or (0.5, 0.5)
        self.view.zoom(self._chart, _ZOOM_FACTOR**-direction, centre)
        self._handle_new_limits()

    def action_zoom_y(self, direction: int) -> None:
        """Zoom in (-1) or out (+1), only along y."""
        self.view.zoom_y(self._chart, _ZOOM_FACTOR**-direction)
        self._handle_new_limits()

    def action_step(self, right: int, up: int) -> None:
        """Move the active cursor if it is pinned (does not follow the pointer), else pan."""
        picture = self.current_picture()
        if self.view.cursors.pinned and picture is not None:
            area = picture.plot_area
            if step_cursor(self._chart, self.view, (right, up), (area.columns, area.rows)):
                self._handle_new_limits()
            self._handle_moved_cursor()
        else:
            self.view.pan(self._chart, _PAN_SHARE * right, _PAN_SHARE * up)
            self._handle_new_limits()

    def action_show_end(self, at_end: bool) -> None:
        """Show the start or the end of the data; a pinned cursor goes to the visible end."""
        position = cursor_position(self._chart, self.view)
        if self.view.cursors.pinned and position is not None:
            self._move_cursor((float(at_end), position[1]))
        else:
            self.view.show_end(self._chart, at_end=at_end)
            self._handle_new_limits()

    def action_half_page(self, direction: int) -> None:
        """Pan by half of the visible range of x."""
        self.view.pan(self._chart, 0.5 * direction)
        self._handle_new_limits()

    def action_fit(self) -> None:
        """Fit both axes to the data."""
        self.view.reset()
        self._handle_new_limits()

    def action_log(self, axis: str) -> None:
        """Switch an axis between linear and logarithmic."""
        self.view.toggle_log(x=axis == "x")
        self._handle_new_limits()

    def action_trace(self, number: int) -> None:
        """Hide or show a trace."""
        if self.view.toggle_trace(self._chart, number - 1):
            self.redraw()

    def action_limits(self) -> None:
        """Ask for axis limits."""

        def apply(axes: Sequence[Axis | None] | None) -> None:
            if axes is not None:
                self.view.set_limits(self._chart, *axes)
                self._handle_new_limits()

        self.app.push_screen(LimitsDialog(self._chart, self.view), apply)

    # The cursors

    def action_cursor(self, number: int) -> None:
        """Make the first (0) or second (1) cursor active; if it is active, switch it off."""
        switch_cursor(self._chart, self.view, second=bool(number))
        self._handle_moved_cursor()

    def action_cursor_off(self) -> None:
        """Switch the cursors off."""
        self.view.cursors.clear()
        self._handle_moved_cursor()

    def _handle_moved_cursor(self) -> None:
        self.redraw()
        self.post_message(self.CursorMoved(self))

    def _move_cursor(self, position: Position) -> None:
        move_cursor(self._chart, self.view, position)
        self._handle_moved_cursor()

    def action_open(self) -> None:
        """Open the point nearest to the cursor, which is first switched on if it is off."""
        if self.view.cursors.active_position is None:
            self.action_cursor(0)
        for point in points_at(self._chart, self.view, self.view.cursors.active_position)[:1]:
            self.post_message(self.PointChosen(point))

    # The mouse

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Pan while dragging, else let a cursor that is not pinned follow the pointer."""
        picture = self.current_picture()
        if picture is None:
            return
        area = picture.plot_area
        if self._drag_position is not None:
            right, down = event.x - self._drag_position[0], event.y - self._drag_position[1]
            if right or down:
                self._drag_position, self._was_dragged = (event.x, event.y), True
                # Without chosen limits (None) the y axis fits the data and does not pan.
                y_fits_data = not self._chart.is_plane and self.view.y is None
                up = 0.0 if y_fits_data else down / area.rows
                self.view.pan(self._chart, -right / area.columns, up)
                self._handle_new_limits()
        elif not self.view.cursors.pinned:
            if position := picture.axis_positions(event.x, event.y):
                self._move_cursor(position)
            elif self.view.cursors.active_position is not None:
                self.action_cursor_off()

    def on_leave(self, event: events.Leave) -> None:
        """Hide a cursor that follows the pointer."""
        cursors = self.view.cursors
        if event.node is self and not cursors.pinned and cursors.active_position is not None:
            self.action_cursor_off()

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Start dragging."""
        self._was_dragged = False
        picture = self.current_picture()
        if picture is not None and event.y >= picture.plot_area.top_row:
            self._drag_position = (event.x, event.y)
            self.capture_mouse()

    def on_mouse_up(self, _event: events.MouseUp) -> None:
        """End dragging."""
        self._drag_position = None
        self.release_mouse()

    @on(events.MouseScrollUp)
    @on(events.MouseScrollDown)
    def _zoom_at_pointer(self, event: events.MouseScrollUp | events.MouseScrollDown) -> None:
        picture = self.current_picture()
        if picture is not None:
            event.stop()
            direction = -1 if isinstance(event, events.MouseScrollDown) else 1
            centre = picture.axis_positions(event.x, event.y) or (0.5, 0.5)
            self.view.zoom(self._chart, _WHEEL_FACTOR**direction, centre)
            self._handle_new_limits()

    async def on_click(self, event: events.Click) -> None:
        """Press a control, toggle a trace, place a cursor, or open a point (double click).

        The right button places the second cursor.
        """
        picture = self.current_picture()
        if picture is None or self._was_dragged:
            return
        # Controls and entries of the legend have an action, of the chart or of a widget around it.
        if action := self.screen.get_style_at(event.screen_x, event.screen_y).meta.get("action"):
            name = f"action_{action.partition('(')[0]}"
            owner = next(node for node in self.ancestors_with_self if hasattr(node, name))
            await self.app.run_action(action, owner)
            return
        position = picture.axis_positions(event.x, event.y)
        if position is None:
            return
        cursors = self.view.cursors
        second = event.button == _RIGHT_BUTTON
        if second and not cursors.pinned:
            # The first cursor followed the pointer to the click: place it at its initial position.
            cursors.first = None
            self.action_cursor(0)
        cursors.pinned, cursors.second_is_active = True, second
        self._move_cursor(position)
        if event.chain == 2 and self._runs_points:
            self.action_open()

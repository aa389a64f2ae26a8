"""The slider on the belt, animated."""

import time
from typing import ClassVar, Final

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.events import Resize

from fivtui.film import Layout, Timing, belt_chart, layout_of, watchable_speed
from fivtui.transient import Transient
from fivtui.tui.chart import ChartView

_FRAMES_PER_SECOND: Final = 20
# Factor by which a key changes the speed.
_SPEED_FACTOR: Final = 2.0
# Time by which a key steps, in seconds of the animation.
_STEP_S: Final = 0.04
# Approximate ratio of width to height of a character cell.
_CELL_ASPECT: Final = 0.5
# Columns and rows of the chart outside its plot.
_MARGINS: Final = (8, 3)


class BeltView(Vertical):
    """The slider on the belt at time `t`, s; in motion, `speed` simulated seconds pass a second."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "play", "Play or stop", key_display="Space"),
        Binding("full_stop", "step_time(1)", "Forward", key_display="."),
        Binding("comma", "step_time(-1)", "Back", key_display=","),
        Binding("greater_than_sign", "change_speed(1)", "Faster", key_display=">"),
        Binding("less_than_sign", "change_speed(-1)", "Slower", key_display="<"),
        Binding("g,home", "go_to(0.0)", "Start", show=False),
        Binding("G,end", "go_to(1e9)", "End", show=False),
    ]

    def __init__(self) -> None:
        super().__init__(id="belt")
        self.t, self.speed = 0.0, 1.0
        self._run: Transient | None = None
        self._layout: Layout | None = None
        # Clock time of the last frame, s; 0 while the slider is still.
        self._last_frame_time = 0.0

    def compose(self) -> ComposeResult:
        """The picture."""
        yield ChartView("belt-picture")

    def on_mount(self) -> None:
        """Prepare the timer of the animation."""
        self._timer = self.set_interval(1.0 / _FRAMES_PER_SECOND, self._tick, pause=True)

    @property
    def playing(self) -> bool:
        """Whether the slider moves."""
        return self._last_frame_time > 0.0

    def show_run(self, run: Transient, t: float | None = None) -> None:
        """Show a run at time `t`, s, or at the current time."""
        if run is not self._run and run.trajectory is not None:
            self._run, self._layout = run, layout_of(run.trajectory)
            self.speed = watchable_speed(run)
        self.action_go_to(self.t if t is None else t)

    @on(Resize)
    def draw(self) -> None:
        """Draw the slider at the current time."""
        if self._run is None or self._layout is None:
            return
        view = self.query_one(ChartView)
        columns, rows = view.size.width - _MARGINS[0], view.size.height - _MARGINS[1]
        aspect = _CELL_ASPECT * max(columns, 1) / max(rows, 1)
        timing = Timing(0.0, self._run.t_end, self.speed)
        view.show(belt_chart(self._run, self._layout, timing, self.t, aspect))

    def stop(self) -> None:
        """Stop the motion."""
        self._last_frame_time = 0.0
        self._timer.pause()

    def action_play(self) -> None:
        """Let the slider move, from the start if it is at the end, or stop it."""
        if self.playing:
            self.stop()
        elif self._run is not None:
            self.t = self.t if self.t < self._run.t_end else 0.0
            self._last_frame_time = time.monotonic()
            self._timer.resume()

    def _tick(self) -> None:
        if self._run is None or not self.playing:
            return
        frame_time = time.monotonic()
        elapsed = frame_time - self._last_frame_time
        self.t = min(self.t + elapsed * self.speed, self._run.t_end)
        self._last_frame_time = frame_time
        if self.t >= self._run.t_end or not self.is_on_screen:
            self.stop()
        self.draw()

    def action_step_time(self, direction: int) -> None:
        """Step forward or back."""
        self.stop()
        self.action_go_to(self.t + direction * _STEP_S * self.speed)

    def action_go_to(self, t: float) -> None:
        """Show a time, s, within the run."""
        if self._run is not None:
            self.t = min(max(t, 0.0), self._run.t_end)
            self.draw()

    def action_change_speed(self, direction: int) -> None:
        """Let time pass twice or half as fast."""
        self.speed *= _SPEED_FACTOR**direction
        self.draw()

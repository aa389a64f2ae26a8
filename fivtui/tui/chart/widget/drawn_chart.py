"""A chart drawn in a widget, in the styles of the theme."""

from dataclasses import dataclass
from textwrap import wrap
from typing import Final

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

from fivtui.charts import Chart, Cursors, Span, View, needs_full_line
from fivtui.tui.chart.picture import MARGIN, Picture, draw
from fivtui.tui.chart.styles import CHART_STYLES, FOCUSED_STYLES

_WIDE: Final = 90
_INDENT: Final = " "
_MIN_SIZE: Final = (MARGIN + 2, 3)


@dataclass(frozen=True, slots=True)
class _Control:
    # A clickable label at the end of the heading, with a short form for narrow charts.
    action: str
    label: str
    brief: str


_CONTROLS: Final = (
    _Control("log('x')", "log x", "logx"),
    _Control("log('y')", "log y", "logy"),
    _Control("limits", "limits", "lim"),
    _Control("whole", "fit", "fit"),
)


class DrawnChart(Widget):
    """A chart, or a text instead, with clickable controls at the end of its heading."""

    def __init__(self, id: str, *, nothing: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self.view = View()
        # Cursors by their quantity, which charts share, or by chart.
        self.linked: dict[str, Cursors] = {}
        self._chart: Chart | None = None
        self._nothing = nothing
        self._picture: Picture | None = None
        self._styles_by_name: dict[str, Style] = {}
        self._controls: list[tuple[int, int, str]] = []

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

    def notify_style_update(self) -> None:
        """Follow a change of theme."""
        self._styles_by_name.clear()
        super().notify_style_update()

    def _style(self, name: str) -> Style:
        if name not in self._styles_by_name:
            styles = {**CHART_STYLES, **(FOCUSED_STYLES if self.has_focus else {})}
            style = self.app.stylesheet.parse_style(styles.get(name, name))
            self._styles_by_name[name] = (self.visual_style + style).rich_style
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
        if self._chart is None or width < _MIN_SIZE[0] or height < _MIN_SIZE[1]:
            below = wrap(self._nothing, max(width - len(_INDENT) - 1, 1))
            return [[("", "plot")], *([(f"{_INDENT}{line}", "label")] for line in below)]
        if self._picture is None:
            self._controls.clear()
            crowded = width < _WIDE and needs_full_line(self._chart, self.view)
            controls = [] if crowded else self._heading_end(width)
            reserved = sum(len(text) for text, _ in controls)
            self._picture = draw(self._chart, self.view, width, height, reserved=reserved)
            # The last span of the first line is the reserved space.
            self._picture.lines[0][-1:] = controls
        return self._picture.lines

    def _drawn(self) -> Picture | None:
        # Draw first: keys may come before the frame. A chart that does not fit has no picture.
        self._lines()
        return self._picture

    def _heading_end(self, width: int) -> list[Span]:
        wide = width >= _WIDE
        texts = [control.label if wide else control.brief for control in _CONTROLS]
        view = self.view
        limited = view.x is not None or view.y is not None
        on = {"log('x')": view.log_x, "log('y')": view.log_y, "whole": limited}
        column = width - sum(len(text) + 1 for text in texts)
        spans: list[Span] = []
        for control, text in zip(_CONTROLS, texts, strict=True):
            style = "control-on" if on.get(control.action) else "control"
            spans += [(" ", "plot"), (text, style)]
            self._controls.append((column + 1, column + 1 + len(text), control.action))
            column += len(text) + 1
        return spans

    def on_resize(self) -> None:
        """Draw for the new size."""
        self.redraw()

"""A widget that draws a chart in the styles of the theme.

The heading in the first line ends with clickable controls for the limits and scales of the axes.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from textwrap import wrap
from typing import Final

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual import on
from textual.content import Content
from textual.events import Blur, Focus, Resize
from textual.geometry import Region
from textual.reactive import var
from textual.strip import Strip
from textual.theme import Theme
from textual.widget import Widget

from fivtui.charts import (
    BLANK,
    INKS,
    Chart,
    Cursors,
    PlotColours,
    Span,
    View,
    has_long_heading,
    mix,
    scale_swatches,
    screen_colours,
)
from fivtui.tui.chart.picture import MARGIN, Picture, draw

# Minimum columns for full labels of the controls.
_WIDE_COLUMNS: Final = 90
# Before the text that replaces a chart.
_INDENT: Final = " "
# Minimum columns and rows of a chart.
_MIN_SIZE: Final = (MARGIN + 2, 3)
_MUTED: Final = "$foreground-muted"
# Swatch of a shade in a picture, as wide as a character, so that the scale keeps its lines.
_SWATCH: Final = "█"
_BLACK: Final = Color.from_rgb(0, 0, 0)

# Styles by the style names of spans: roles of colours, and others in colours of the theme. A strip
# is a row of shades below the plot.
# Rules of a style sheet would be slow: Textual evaluates them for every chart at every change.
CHART_STYLES: Final[Mapping[str, str]] = {
    "plot": "",
    "tick": _MUTED,
    "label": _MUTED,
    "cursor": "bold $accent",
    "cursor-2": "bold $foreground",
    "zoomed": "bold $accent",
    "outside": "bold $warning",
    "readout": "bold $accent",
    "hidden": f"strike {_MUTED}",
    "strip": "$reference",
    "control": _MUTED,
    "control-on": "reverse",
    **{role: f"${role}" for role in INKS},
}

# Styles that differ in a focused chart.
_FOCUSED_STYLES: Final = {"tick": "$foreground", "label": "bold underline $foreground"}
# Roles of colours by the attributes of a theme that have the same meaning.
_THEME_ROLES: Final = {"error": "danger", "warning": "warning", "success": "safe"}


def with_chart_colours(theme: Theme, chosen: Collection[str] = ()) -> Theme:
    """A theme with the colours of charts as variables, named as their roles.

    Error, warning and success have the colours of danger, warning and safe; if `chosen` contains
    them, these roles have the colours of the theme.
    """
    colours = {role: ink.dark if theme.dark else ink.light for role, ink in INKS.items()}
    colours |= {role: getattr(theme, name) for name, role in _THEME_ROLES.items() if name in chosen}
    danger, warning, safe = (colours[role] for role in _THEME_ROLES.values())
    texts = {f"text-{name}": colours[role] for name, role in _THEME_ROLES.items()}
    variables = theme.variables | colours | texts
    return replace(theme, variables=variables, error=danger, warning=warning, success=safe)


@dataclass(frozen=True, slots=True)
class Control:
    """A clickable label at the end of the heading; narrow charts display the short label.

    The action is one of the chart or of a widget around it.
    """

    action: str
    label: str
    short_label: str


_CONTROLS: Final = (
    Control("log('x')", "log x", "logx"),
    Control("log('y')", "log y", "logy"),
    Control("limits", "limits", "lim"),
    Control("fit", "fit", "fit"),
)


_NO_CHART: Final = Chart("", "", ())


class DrawnChart(Widget):
    """A chart with clickable controls at the end of its heading; without chart, a text."""

    # Whether the terminal shows a picture over the characters of the plot.
    is_covered = var(False)

    def __init__(self, id: str, *, empty_text: str = "") -> None:  # noqa: A002
        super().__init__(id=id)
        # Controls of the widgets around the chart, before its own.
        self.extra_controls: Sequence[Control] = ()
        self.view = View()
        # Cursors by the quantity along which they move, which charts may share; cursors of a plane
        # by the identifier of its chart.
        self.shared_cursors: dict[str, Cursors] = {}
        self._chart = _NO_CHART
        self._empty_text = empty_text
        self._picture: Picture | None = None

    @property
    def chart(self) -> Chart | None:
        """The displayed chart."""
        return None if self._chart is _NO_CHART else self._chart

    def text(self) -> str:
        """The drawn chart without styles."""
        return draw(self._chart, self.view, *self.size).text()

    def show(self, chart: Chart | None, *, empty_text: str | None = None) -> None:
        """Display a chart in the current view; without chart, display `empty_text`."""
        if (chart is None) is not (self.chart is None):
            # Without a chart its keys have no effect.
            self.refresh_bindings()
        self._chart = chart or _NO_CHART
        if chart is not None:
            shared_quantity = chart.cursor_label or str(self.id)
            self.view.cursors = self.shared_cursors.setdefault(shared_quantity, Cursors())
        if empty_text is not None:
            self._empty_text = empty_text
        self.redraw()

    @on(Resize)
    @on(Focus)
    @on(Blur)
    def redraw(self) -> None:
        """Draw the chart again, such as in the styles of a focused chart.

        Where a picture covers the plot at its previous place, the plot is not displayed, because
        text would erase the picture.
        """
        previous, self._picture = self._picture, None
        current = self.current_picture() if self.is_covered else None
        if current is None or previous is None or current.plot_area != previous.plot_area:
            self.refresh()
            return
        column, row, _, rows = current.plot_area
        width, height = self.size
        self.refresh(
            Region(0, 0, width, row),
            Region(0, row, column, rows),
            Region(0, row + rows, width, height - row - rows),
        )

    def _style(self, name: str) -> Style:
        role, _, action = name.partition(" ")
        focused_style = _FOCUSED_STYLES.get(role, "") if self.has_focus else ""
        style = self.app.stylesheet.parse_style(focused_style or CHART_STYLES[role])
        return (self.visual_style + style).rich_style + Style(meta={"action": action})

    def plot_colours(self, opacity: float = 1.0) -> PlotColours:
        """The colours of the plot as codes, for pictures.

        `opacity` is that of outdated results, which Textual applies to characters alone.
        """
        background = self.background_colors[0].hex6

        def code(colour: Color | None) -> str:
            return mix((colour or _BLACK).get_truecolor().hex, background, opacity)

        plain = self._style("plot")
        roles = {role: code(self._style(role).color) for role in INKS}
        return PlotColours(code(plain.bgcolor), code(plain.color), roles)

    def render_line(self, y: int) -> Strip:
        """A line of the picture."""
        lines = self._drawn_lines()
        spans = lines[y] if y < len(lines) else []
        segments = [Segment(text, self._style(name)) for text, name in spans]
        return Strip(segments).adjust_cell_length(self.size.width, self._style("plot"))

    def _drawn_lines(self) -> list[list[Span]]:
        width, height = self.size
        if self.chart is None or width < _MIN_SIZE[0] or height < _MIN_SIZE[1]:
            text_lines = wrap(self._empty_text, max(width - len(_INDENT) - 1, 1))
            return [[("", "plot")], *([(f"{_INDENT}{line}", "label")] for line in text_lines)]
        if self._picture is None:
            controls = self._control_spans(width)
            control_width = sum(len(text) for text, _ in controls)
            self._picture = draw(self._chart, self.view, width, height, reserved=control_width)
            if self._picture.plot_area.top_row > 1 and has_long_heading(self._chart, self.view):
                # A heading that does not fit beside the controls takes their place.
                controls = []
                self._picture = draw(self._chart, self.view, width, height)
            # The last span of the first line is blank: it has the columns reserved for controls.
            self._picture.lines[0][-1:] = controls
        return self._picture.lines

    def current_picture(self) -> Picture | None:
        """The picture of the chart in its current view; None if the chart does not fit."""
        self._drawn_lines()
        return self._picture

    def _control_spans(self, width: int) -> list[Span]:
        view = self.view
        has_limits = view.x is not None or view.y is not None
        is_on = {"log('x')": view.log_x, "log('y')": view.log_y, "fit": has_limits}
        spans: list[Span] = []
        for control in (*self.extra_controls, *_CONTROLS):
            text = control.label if width >= _WIDE_COLUMNS else control.short_label
            style = "control-on" if is_on.get(control.action) else "control"
            spans += [(" ", "plot"), (text, f"{style} {control.action}")]
        return spans


class ShadeScale(Widget):
    """The values of the shades of a chart, beside swatches in the colours of its plot."""

    def __init__(self, chart_view: DrawnChart) -> None:
        super().__init__()
        self._chart_view = chart_view
        self.display = False

    def on_mount(self) -> None:
        """Follow the chart from characters to a picture and back."""
        self.watch(self._chart_view, "is_covered", self.redraw, init=False)

    def redraw(self) -> None:
        """Follow another chart; without shades there is no scale."""
        chart = self._chart_view.chart
        self.display = chart is not None and chart.backdrop is not None
        self.refresh(layout=True)

    def render(self) -> Content:
        """Swatch and values of each shade; without shades nothing."""
        chart, is_picture = self._chart_view.chart, self._chart_view.is_covered
        if chart is None or chart.backdrop is None:
            return Content("")
        entries = []
        with screen_colours(self._chart_view.plot_colours()):
            for swatch, shade in scale_swatches(chart.backdrop.shades):
                if swatch == BLANK:
                    span = swatch, ""
                elif is_picture:
                    span = _SWATCH, shade.figure_colour
                else:
                    span = swatch, CHART_STYLES[shade.style]
                entries.append(Content.assemble(span, f" {shade.text}"))
        return Content(" ").join(entries)

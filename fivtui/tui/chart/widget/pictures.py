"""Draws the plots of charts as pictures, in terminals that answer that they can show them.

Charts are always drawn in characters. A terminal that understands sixel or kitty's graphics shows a
picture over the characters of the plot, once a thread has drawn it.
"""

import re
import struct
import sys
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from operator import itemgetter
from typing import Any, Final
from zlib import crc32

from rich.control import Control
from textual._compositor import ChopsUpdate, Compositor, CompositorUpdate, LayoutUpdate
from textual._xterm_parser import XTermParser
from textual.app import App
from textual.geometry import Region, Size
from textual.message import Message
from textual.screen import Screen
from textual.timer import Timer
from textual.widget import Widget

from fivtui.charts import Chart, PlotColours, View
from fivtui.tui.chart.graphics import (
    CELL_QUERY,
    GRAPHICS_QUERY,
    SIXEL_ATTRIBUTE,
    delete_kitty,
    encode_kitty,
    encode_sixel,
)
from fivtui.tui.chart.picture import axis_ticks

from .drawn_chart import DrawnChart

# Answers to the queries: kitty's graphics, attributes, size of a cell in pixels.
_REPLY: Final = re.compile(
    r"\x1b_Gi=31;(?P<kitty>[^\x1b]*)\x1b\\"
    r"|\x1b\[\?(?P<attributes>[\d;]*)c"
    r"|\x1b\[6;(?P<height>\d+);(?P<width>\d+)t"
)
_INCOMPLETE_REPLY: Final = re.compile(r"\x1b(_G[^\x1b]*\x1b?|\[\?[\d;]*|\[6;[\d;]*)\Z")
# Dots per inch of figures per pixel of a cell's height: text is nearly as high as the terminal's.
_DPI_PER_PIXEL: Final = 6.0
# Xterm cuts wider pictures off, pixels.
_MAX_SIXEL_WIDTH: Final = 960
# Keys that follow at most this time after the one before are those of a held key, s.
_HELD_S: Final = 0.25


@dataclass
class TerminalReply(Message):
    """An answer of the terminal to a query, as a match of `_REPLY`."""

    match: re.Match[str]


class _ReplyParser(XTermParser):
    # Removes answers to queries from what is typed: Textual would take them for keys.

    _incomplete_reply = ""

    def feed(self, data: str) -> Iterator[Message]:
        text, self._incomplete_reply = self._incomplete_reply + data, ""
        replies = list(_REPLY.finditer(text))
        typed = _REPLY.sub("", text)
        if data and (incomplete := _INCOMPLETE_REPLY.search(typed)):
            typed, self._incomplete_reply = typed[: incomplete.start()], incomplete[0]
        yield from map(TerminalReply, replies)
        if typed or not data:
            yield from super().feed(typed)


@dataclass(frozen=True, slots=True)
class _Plot:
    # What a picture shows. Compared with the plot on the screen to find out whether that is old.
    chart: Chart
    view: View
    colours: PlotColours
    # The covered cells of the screen, and the pixels of a cell.
    area: Region
    cell: Size


@dataclass(frozen=True, slots=True)
class _Picture:
    # A picture as text by columns from its left edge, and the command that removes it.
    plot: _Plot
    number: int
    checksum: int
    texts: Mapping[int, str]
    removal: str


def write_changes(app: App[None]) -> None:
    """Write pictures and cells that were deferred: the application displays an empty update."""
    update: Any = CompositorUpdate()
    app._display(app.screen, update)


class Pictures:
    """Pictures of the visible charts; none until a terminal answers that it can show them.

    A picture stays until that of the changed chart is drawn. The next one waits until the terminal
    has read the last one. While a key is held, charts are in characters, which follow at once.
    `wait` delays the drawing while the screen responds to a key.
    """

    def __init__(
        self, app: App[None], wait: Callable[[], None], report: Callable[[str], object]
    ) -> None:
        self._app, self._wait, self._report = app, wait, report
        # Drivers make their parser by its name in their modules; some, such as that of tests, make
        # none, and cannot ask the terminal.
        driver_module: Any = sys.modules[app.driver_class.__module__]
        self.can_ask = hasattr(driver_module, "XTermParser")
        if self.can_ask:
            driver_module.XTermParser = _ReplyParser
        self._write: Callable[[str], None] = lambda _: None
        # "kitty", "sixel", or nothing.
        self._protocol = ""
        # Pixels of a cell; empty if unknown.
        self._cell = Size()
        self._screen_size = Size()
        self._numbers = count(1)
        self._is_drawing = False
        # Whether pictures may wait until the terminal has read what was written.
        self._may_wait = False
        # Whether the last key followed the one before at once, and the timer that runs since then.
        self._is_key_held = False
        self._rest: Timer | None = None
        # By chart: plots on the screen, their newest pictures, and the pictures on the screen.
        self._visible: dict[DrawnChart, _Plot] = {}
        self._drawn: dict[DrawnChart, _Picture] = {}
        self._shown: dict[DrawnChart, _Picture] = {}

    def start(self, write: Callable[[str], None]) -> None:
        """Ask the terminal what it can show; `write` sends text to it."""
        self._write = write
        self._cell = _cell_size()
        write(GRAPHICS_QUERY)

    def note_key(self) -> None:
        """Note that a key or a button was pressed."""
        if self._protocol:
            self._is_key_held = self._rest is not None
            if self._rest is not None:
                # `Timer.reset` would wait for the end of the current interval first.
                self._rest.stop()
            self._rest = self._app.set_timer(_HELD_S, self._end_held_key)

    def _end_held_key(self) -> None:
        self._is_key_held, self._rest = False, None
        write_changes(self._app)

    def resume(self) -> None:
        """Show pictures that wait: the terminal has read what was written."""
        if self._may_wait:
            self._may_wait = False
            write_changes(self._app)

    def stop(self, reason: str) -> None:
        """Remove all pictures, and show no more."""
        if self._protocol:
            self._protocol = ""
            self._visible.clear()
            self._write(self._commands(may_send=False))
            self._report(f"pictures are off: {reason}")

    def read(self, reply: TerminalReply) -> None:
        """Handle an answer of the terminal."""
        if reply.match["kitty"] == "OK":
            self._protocol = "kitty"
        elif width := reply.match["width"]:
            self._cell = Size(int(width), int(reply.match["height"] or 0))
        elif SIXEL_ATTRIBUTE in (reply.match["attributes"] or "").split(";")[1:]:
            self._protocol = self._protocol or "sixel"
        write_changes(self._app)

    def text(self, screen: Screen[Any], update: CompositorUpdate, *, may_send: bool) -> str:
        """What follows an update of the screen: removals, and if they may be sent, pictures."""
        if not self._protocol:
            return ""
        if self._protocol == "sixel":
            # Text erases a picture.
            for chart, picture in list(self._shown.items()):
                if _overlaps(update, picture.plot.area):
                    self._forget(chart)
        is_shown = screen is self._app.screen and self._cell and not self._is_key_held
        self._visible = self._find_visible(screen._compositor) if is_shown else {}
        self._may_wait = not may_send
        commands = self._commands(may_send=may_send)
        if screen.size != self._screen_size:
            # The size of the font may have changed.
            self._screen_size, self._cell = screen.size, _cell_size() or self._cell
            commands += CELL_QUERY
        self._draw_next()
        return commands

    def _find_visible(self, compositor: Compositor) -> dict[DrawnChart, _Plot]:
        visible: dict[DrawnChart, _Plot] = {}
        for widget, (region, clip) in compositor.visible_widgets.items():
            if not isinstance(widget, DrawnChart):
                continue
            picture, chart = widget.current_picture(), widget.chart
            if picture is None or chart is None:
                continue
            area = Region(*picture.plot_area).translate(region.offset)
            if clip.contains_region(area) and not _is_covered(widget, area, compositor):
                colours = widget.plot_colours(widget.opacity)
                visible[widget] = _Plot(chart, deepcopy(widget.view), colours, area, self._cell)
        return visible

    def _commands(self, *, may_send: bool) -> str:
        # Text that removes pictures of charts that are not visible, and shows new pictures.
        commands = []
        for chart, shown in list(self._shown.items()):
            if chart not in self._visible or self._visible[chart].area != shown.plot.area:
                commands.append(shown.removal)
                self._forget(chart)
                # The characters may have changed below the picture.
                chart.refresh()
        for chart, plot in self._visible.items() if may_send else ():
            newest, previous = self._drawn.get(chart), self._shown.get(chart)
            if newest is None or (newest.plot.area, newest.plot.cell) != (plot.area, plot.cell):
                continue
            if previous is not None and previous.number == newest.number:
                continue
            for column, text in newest.texts.items():
                commands += [str(Control.move_to(plot.area.x + column, plot.area.y)), text]
            if previous is not None:
                commands.append(previous.removal)
            self._shown[chart] = newest
            chart.is_covered = True
        return "".join(commands)

    def _forget(self, chart: DrawnChart) -> None:
        del self._shown[chart]
        chart.is_covered = False

    def _draw_next(self) -> None:
        # Draw the visible plot that has changed and was not drawn for the longest time.
        changed = [
            (picture.number if picture is not None else 0, chart, plot)
            for chart, plot in self._visible.items()
            if (picture := self._drawn.get(chart)) is None or picture.plot != plot
        ]
        if changed and not self._is_drawing:
            self._is_drawing = True
            _, chart, plot = min(changed, key=itemgetter(0))
            draw = partial(self._draw, chart, plot, next(self._numbers))
            self._app.run_worker(draw, thread=True, exit_on_error=False)

    def _draw(self, chart: DrawnChart, plot: _Plot, number: int) -> None:
        # Runs in a thread.
        self._wait()
        try:
            picture = self._encode(plot, number)
        except Exception as error:  # noqa: BLE001 (it is reported, and charts stay in characters)
            self._app.call_later(self.stop, f"a chart cannot be drawn: {error!r}")
        else:
            self._app.call_later(self._finish, chart, picture)

    def _encode(self, plot: _Plot, number: int) -> _Picture:
        # Imported late, because matplotlib loads slowly.
        from fivtui.charts import plot_pixels

        (columns, rows), (width, height) = plot.area.size, plot.cell
        pixels = plot_pixels(
            plot.chart,
            plot.view,
            (columns * width, rows * height),
            dpi=_DPI_PER_PIXEL * height,
            colours=plot.colours,
            ticks=axis_ticks(plot.chart, plot.view, columns, rows),
        )
        if self._protocol == "kitty":
            texts, removal = {0: encode_kitty(pixels, number, columns, rows)}, delete_kitty(number)
        else:
            step = max(_MAX_SIXEL_WIDTH // width, 1)
            texts = {
                column: encode_sixel(pixels[:, column * width : (column + step) * width])
                for column in range(0, columns, step)
            }
            removal = ""
        return _Picture(plot, number, crc32(pixels.tobytes()), texts, removal)

    def _finish(self, chart: DrawnChart, picture: _Picture) -> None:
        self._is_drawing = False
        previous = self._drawn.get(chart)
        if previous is not None and previous.checksum == picture.checksum:
            # The same picture need not be sent again.
            picture = replace(previous, plot=picture.plot)
        self._drawn[chart] = picture
        write_changes(self._app)


def _cell_size() -> Size:
    # Pixels of a cell of the terminal; empty if the system does not tell. Xterm answers no query.
    try:
        import fcntl
        import termios

        window = fcntl.ioctl(sys.__stdout__ or -1, termios.TIOCGWINSZ, bytes(8))
    except (ImportError, OSError, ValueError):
        return Size()
    rows, columns, width, height = struct.unpack("HHHH", window)
    return Size(width // max(columns, 1), height // max(rows, 1))


def _overlaps(update: CompositorUpdate, area: Region) -> bool:
    # Whether an update of the screen writes text into an area.
    return isinstance(update, LayoutUpdate) or any(
        area.y <= row < area.bottom and start < area.right and stop > area.x
        for row, start, stop in (update.spans if isinstance(update, ChopsUpdate) else ())
    )


def _is_covered(widget: Widget, area: Region, compositor: Compositor) -> bool:
    # Whether other widgets are displayed in an area of a widget.
    for row in area.line_range:
        # The topmost widget is first.
        for upper_widget, region, _ in compositor.layers_visible[row]:
            if upper_widget is widget:
                break
            if region.overlaps(area):
                return True
    return False

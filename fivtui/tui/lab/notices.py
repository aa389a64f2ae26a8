"""Notices: the latest messages, in a few lines at the lower edge of the main screen."""

from textwrap import shorten, wrap
from typing import Final

from textual import on
from textual.content import Content
from textual.events import Click
from textual.widget import Widget

from fivtui.tui.tabs import Reported

# Notices cover the lower edge of the form, where its hint has three lines, but no button or field.
_MAX_LINES: Final = 3
_DISPLAY_TIME_S: Final = 5.0
_LEFT_EDGE: Final = "▌ "
# Ends a message that is too long.
_CUT_MARK: Final = "… (tab Log)"


class NoticeView(Widget):
    """Shows notices for some seconds; newer ones replace older ones, and a click removes all.

    Textual's notifications could cover any number of buttons.
    """

    def __init__(self) -> None:
        super().__init__()
        self.notices: list[Reported] = []

    def add(self, notice: Reported) -> None:
        """Show a message for some seconds."""
        self.notices.append(notice)
        self.set_timer(_DISPLAY_TIME_S, lambda: self._remove(notice))
        self._update_display()

    def _remove(self, notice: Reported) -> None:
        if notice in self.notices:
            self.notices.remove(notice)
            self._update_display()

    def _update_display(self) -> None:
        while len(self.notices) > 1 and len(self._wrapped_lines()) > _MAX_LINES:
            del self.notices[0]
        self.display = bool(self.notices)
        self.refresh(layout=True)

    def _wrapped_lines(self) -> list[tuple[str, Reported]]:
        width = max(self.screen.size.width - len(_LEFT_EDGE) - 1, len(_CUT_MARK))
        styled_lines: list[tuple[str, Reported]] = []
        for notice in self.notices:
            lines = wrap(notice.text, width)
            if len(lines) > _MAX_LINES:
                remainder = " ".join(lines[_MAX_LINES - 1 :])
                lines[_MAX_LINES - 1 :] = [shorten(remainder, width, placeholder=_CUT_MARK)]
            styled_lines += [(line, notice) for line in lines]
        return styled_lines

    def render(self) -> Content:
        """The lines of all messages, each with a coloured edge: that of warnings for an error."""
        return Content("\n").join(
            Content.assemble((_LEFT_EDGE, "$warning" if notice.error else "$success"), line, " ")
            for line, notice in self._wrapped_lines()
        )

    @on(Click)
    def clear(self) -> None:
        """Remove the notices."""
        self.notices.clear()
        self._update_display()

"""Notices: the last messages, in a few lines over the lower edge of the main screen."""

from dataclasses import dataclass
from textwrap import shorten, wrap
from typing import Final

from textual.content import Content
from textual.widget import Widget

# As high as the hint about a field, so that no button or field is covered.
_LINES: Final = 3
_SHOWN_S: Final = 5.0
_EDGE: Final = "▌ "
_MORE: Final = "… (tab Log)"


@dataclass(eq=False, frozen=True, slots=True)
class Notice:
    """A message, and whether it is an error."""

    text: str
    error: bool


class NoticeView(Widget):
    """The notices of the last seconds; newer ones replace older ones, and a click removes all.

    Textual's notifications would cover buttons without limit.
    """

    def __init__(self) -> None:
        super().__init__()
        self.notices: list[Notice] = []

    def add(self, text: str, *, error: bool) -> None:
        """Show a message for some seconds."""
        notice = Notice(text, error)
        self.notices.append(notice)
        self.set_timer(_SHOWN_S, lambda: self._end(notice))
        self._follow()

    def _end(self, notice: Notice) -> None:
        if notice in self.notices:
            self.notices.remove(notice)
            self._follow()

    def _follow(self) -> None:
        while len(self.notices) > 1 and len(self._lines()) > _LINES:
            del self.notices[0]
        self.display = bool(self.notices)
        self.refresh(layout=True)

    def _lines(self) -> list[tuple[str, Notice]]:
        width = max(self.screen.size.width - len(_EDGE) - 1, len(_MORE))
        styled_lines: list[tuple[str, Notice]] = []
        for notice in self.notices:
            lines = wrap(notice.text, width)
            if len(lines) > _LINES:
                remainder = " ".join(lines[_LINES - 1 :])
                lines[_LINES - 1 :] = [shorten(remainder, width, placeholder=_MORE)]
            styled_lines += [(line, notice) for line in lines]
        return styled_lines

    def render(self) -> Content:
        """The lines of all messages, each with an edge in the colour of its kind."""
        return Content("\n").join(
            Content.assemble((_EDGE, "$error" if notice.error else "$success"), line, " ")
            for line, notice in self._lines()
        )

    def on_click(self) -> None:
        """Remove the notices."""
        self.clear()

    def clear(self) -> None:
        """Remove the notices."""
        self.notices.clear()
        self._follow()

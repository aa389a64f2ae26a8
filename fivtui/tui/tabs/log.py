"""The log tab."""

from collections.abc import Sequence
from typing import Final

from textual.app import ComposeResult
from textual.content import Content

from .pane import Pane
from .search import TextView

_EMPTY_TEXT: Final = Content.styled(
    "Reports of runs, files and errors follow.", "$foreground-muted"
)


class LogView(TextView[str]):
    """The lines of the log."""

    # RichLog is unsuitable: it draws nothing before Textual sends it a size, and if it was
    # scrolled, Textual may send none.
    def text_of(self, line: str) -> str:
        """The line."""
        return line

    def content_of(self, lines: Sequence[str]) -> Content:
        """The lines as one text."""
        return Content("\n".join(lines))


class LogPane(Pane):
    """All reports of the session, newest last."""

    def compose(self) -> ComposeResult:
        """The lines."""
        yield LogView(id="log-lines")

    def on_mount(self) -> None:
        """Start without displayed reports."""
        self._displayed_count = 0
        self.query_one(LogView).show([], _EMPTY_TEXT)

    def report_added(self) -> None:
        """Show all reports; new reports scroll to the end."""
        lines = self.session.reports
        if len(lines) > self._displayed_count:
            view = self.query_one(LogView)
            view.show(lines)
            view.scroll_end(animate=False)
        self._displayed_count = len(lines)

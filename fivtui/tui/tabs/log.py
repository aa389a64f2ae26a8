"""The log tab."""

from collections.abc import Sequence
from typing import Final

from textual.app import ComposeResult
from textual.content import Content
from textual.widgets import Static

from .pane import Pane
from .search import TextView

_EMPTY_TEXT: Final = Content.styled(
    "Reports of runs, files and errors follow.", "$foreground-muted"
)


class LogView(TextView):
    """The lines of the log."""

    lines: Sequence[str] = ()

    # RichLog is unsuitable: it draws nothing before Textual sends it a size, and if it was
    # scrolled, Textual may send none.
    def compose(self) -> ComposeResult:
        """The lines, or what they will be."""
        yield Static(_EMPTY_TEXT)

    def show(self, lines: Sequence[str]) -> None:
        """Display lines."""
        self.lines = lines
        self.find("")

    def find(self, text: str) -> bool:
        """Display only the lines that contain a text."""
        lines = [line for line in self.lines if text in line.lower()]
        self.query_one(Static).update(Content("\n".join(lines)) if self.lines else _EMPTY_TEXT)
        return bool(lines)


class LogPane(Pane):
    """All reports of the session, newest last."""

    def compose(self) -> ComposeResult:
        """The lines."""
        yield LogView(id="log-lines")

    def on_mount(self) -> None:
        """Start without displayed reports."""
        self._displayed_count = 0

    def report_added(self) -> None:
        """Show all reports; new reports scroll to the end."""
        lines = self.session.reports
        if len(lines) > self._displayed_count:
            view = self.query_one(LogView)
            view.show(lines)
            view.scroll_end(animate=False)
        self._displayed_count = len(lines)

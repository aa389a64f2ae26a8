"""The log tab."""

from textual.app import ComposeResult
from textual.widgets import RichLog

from .pane import Pane


class LogPane(Pane):
    """All reports of the session, newest last."""

    def compose(self) -> ComposeResult:
        """The lines."""
        yield RichLog(id="log-lines", wrap=True, min_width=20, markup=False)

    def on_mount(self) -> None:
        """Start at the first report."""
        self._written = 0

    def reported(self) -> None:
        """Append new reports."""
        lines = self.session.reports
        view = self.query_one("#log-lines", RichLog)
        for line in lines[self._written :]:
            view.write(line)
        self._written = len(lines)

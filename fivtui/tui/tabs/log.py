"""The tab of all that was reported."""

from textual.app import ComposeResult
from textual.widgets import RichLog

from .pane import Pane


class LogPane(Pane):
    """What was reported, one line each, the newest last."""

    def compose(self) -> ComposeResult:
        """The lines; none is lost while the tab is out of sight."""
        yield RichLog(id="log-lines", wrap=True, min_width=20, markup=False)

    def on_mount(self) -> None:
        """Begin before the first line."""
        self._written = 0

    def reported(self) -> None:
        """Show the lines that are new."""
        lines = self.session.reports
        view = self.query_one("#log-lines", RichLog)
        for line in lines[self._written :]:
            view.write(line)
        self._written = len(lines)

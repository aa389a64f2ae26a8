"""The log tab."""

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from .pane import Pane


class LogPane(Pane):
    """All reports of the session, newest last."""

    def compose(self) -> ComposeResult:
        """The lines."""
        # RichLog is unsuitable: it draws nothing before Textual sends it a size, and if it was
        # scrolled, Textual may send none.
        with VerticalScroll(id="log-lines"):
            yield Static(markup=False)

    def on_mount(self) -> None:
        """Start without displayed reports."""
        self._displayed_count = 0

    def report_added(self) -> None:
        """Show all reports; new reports scroll to the end."""
        lines = self.session.reports
        if len(lines) > self._displayed_count:
            view = self.query_one("#log-lines", VerticalScroll)
            view.query_one(Static).update("\n".join(lines))
            view.scroll_end(animate=False)
        self._displayed_count = len(lines)

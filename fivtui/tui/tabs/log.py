"""The log tab."""

from typing import Final

from textual.app import ComposeResult
from textual.content import Content

from .pane import Pane
from .search import TextView

_EMPTY_TEXT: Final = Content.styled(
    "Reports of runs, files and errors follow.", "$foreground-muted"
)


class LogPane(Pane):
    """All reports of the session, newest last."""

    def compose(self) -> ComposeResult:
        """The lines."""
        yield TextView[tuple[str]](id="log-lines")

    def report_added(self) -> None:
        """Show all reports; new reports scroll to the end."""
        view: TextView[tuple[str]] = self.query_one(TextView)
        if not view.lines or len(self.session.reports) > len(view.lines):
            view.show([(report,) for report in self.session.reports], _EMPTY_TEXT)
            view.scroll_end(animate=False)

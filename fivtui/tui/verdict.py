"""The verdict on the equilibrium, always in sight."""

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static


class VerdictView(Vertical):
    """A headline and a few lines of facts."""

    def compose(self) -> ComposeResult:
        """The two parts."""
        yield Static("", id="headline", markup=False)
        yield Static("", id="facts", markup=False)

    def show(self, kind: str, lines: Sequence[str]) -> None:
        """Show a verdict.

        Parameters
        ----------
        kind : str
            ``stable``, ``unstable``, ``neutral`` or ``invalid``: sets the colour alone.
        lines : sequence of str
            Headline and facts.
        """
        self.set_classes(f"-{kind}")
        self.query_one("#headline", Static).update(lines[0])
        self.query_one("#facts", Static).update("\n".join(lines[1:]))

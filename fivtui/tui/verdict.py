"""The verdict on the equilibrium, always in sight."""

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static


class VerdictView(Vertical):
    """A headline and a few lines of facts."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._shown: tuple[str, ...] = ()

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
        shown = (kind, *lines)
        if shown == self._shown:
            return
        self._shown = shown
        self.set_classes(f"-{kind}")
        # Both parts keep their sizes: a new layout at every key press would be felt.
        self.query_one("#headline", Static).update(lines[0], layout=False)
        self.query_one("#facts", Static).update("\n".join(lines[1:]), layout=False)

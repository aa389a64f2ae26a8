"""The verdict on the equilibrium, always in sight."""

from collections.abc import Sequence
from typing import Final

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import Resize
from textual.widgets import Static

KINDS: Final = ("stable", "coexisting", "searching", "unstable", "neutral", "invalid")


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
            One of `KINDS`: sets the colour alone.
        lines : sequence of str
            Headline and facts.
        """
        shown = (kind, *lines)
        if shown == self._shown:
            return
        self._shown = shown
        for known in KINDS:
            self.set_class(known == kind, f"-{known}")
        # Both parts keep their sizes: a new layout at every key press would be felt.
        self.query_one("#headline", Static).update(lines[0], layout=False)
        self.query_one("#facts", Static).update("\n".join(lines[1:]), layout=False)
        self._fit()

    @on(Resize)
    def _fit(self) -> None:
        # A headline of two lines where it needs them, and where there is room for anything else.
        long = bool(self._shown) and cell_len(self._shown[1]) > self.content_size.width
        self.set_class(long and self.content_size.height > 1, "-long")

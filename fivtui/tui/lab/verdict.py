"""The stability verdict above the tabs."""

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
        """Headline and facts."""
        yield Static("", id="headline", markup=False)
        yield Static("", id="facts", markup=False)

    def show(self, kind: str, lines: Sequence[str]) -> None:
        """Display headline and facts; `kind`, one of `KINDS`, sets the colour."""
        shown = (kind, *lines)
        if shown == self._shown:
            return
        self._shown = shown
        for known in KINDS:
            self.set_class(known == kind, f"-{known}")
        # Sizes stay: a new layout at every key would be noticeable.
        self.query_one("#headline", Static).update(lines[0], layout=False)
        self.query_one("#facts", Static).update("\n".join(lines[1:]), layout=False)
        self._fit()

    @on(Resize)
    def _fit(self) -> None:
        # A two-line headline if it needs it and facts still fit.
        long = bool(self._shown) and cell_len(self._shown[1]) > self.content_size.width
        self.set_class(long and self.content_size.height > 1, "-long")

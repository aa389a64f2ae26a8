"""The stability verdict above the tabs."""

from collections.abc import Iterable, Sequence
from typing import Final

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import Resize
from textual.widgets import Static

from fivtui.tui.tabs import flowed

from .gauge import Gauge, GaugeView

KINDS: Final = ("stable", "coexisting", "searching", "unstable", "neutral", "invalid")
# Longer words of headlines, and shorter ones for little room.
_SHORTER: Final = (
    ("half peak-to-peak ", "±"),
    ("a limit cycle", "cycle"),
    ("growth rate", "growth"),
    (" (from the static start)", ""),
    (" (after a knock)", ""),
)


def fitted(headline: str, width: int) -> str:
    """A headline, in shorter words where it has no room."""
    for long, short in _SHORTER:
        if cell_len(headline) > width:
            headline = headline.replace(long, short)
    return headline


class VerdictView(Vertical):
    """Headline, a few lines of facts, and gauges; the scene's name in the border."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._shown: tuple[str, ...] = ()

    def compose(self) -> ComposeResult:
        """Headline, facts, gauges."""
        yield Static("", id="headline", markup=False)
        yield Static("", id="facts", markup=False)
        yield GaugeView(id="gauge")
        yield GaugeView(id="gauge-beside")

    def show(self, kind: str, lines: Sequence[str], gauges: Iterable[Gauge | str] = ()) -> None:
        """Display headline, facts and up to two gauges; `kind`, of `KINDS`, sets the colour."""
        shown = [*gauges, "", ""]
        for view, gauge in zip(self.query(GaugeView), shown, strict=False):
            view.show(gauge)
        bases = [gauge.basis for gauge in shown if isinstance(gauge, Gauge)]
        self.border_subtitle = bases[0] if bases else ""
        if (kind, *lines) == self._shown:
            return
        self._shown = (kind, *lines)
        for known in KINDS:
            self.set_class(known == kind, f"-{known}")
        self._fit()

    def name_scene(self, title: str) -> None:
        """Display the name of the scene."""
        if title != self.border_title:
            self.border_title = title

    @on(Resize)
    def _fit(self) -> None:
        if not self._shown:
            return
        # Sizes stay: a new layout at every key would be noticeable.
        width, facts = self.content_size.width, self.query_one("#facts", Static)
        headline, known = fitted(self._shown[1], width), list(self._shown[2:])
        if not facts.display:
            headline = flowed([headline, *known[:1]], width).splitlines()[0]
        facts.update(flowed(known, width), layout=False)
        self.query_one("#headline", Static).update(headline, layout=False)
        # A two-line headline if it needs it and facts still fit.
        self.set_class(cell_len(headline) > width and facts.size.height > 1, "-long")

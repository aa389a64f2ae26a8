"""The stability verdict above the tabs."""

from collections.abc import Sequence
from typing import Final

from rich.cells import cell_len
from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import Resize
from textual.widgets import Static

from fivtui.tui.tabs import flow_facts

from .gauge import Gauge, GaugeView

# Kinds of verdicts, which set the colour. Coexisting: stable, but beside another attractor, such as
# a limit cycle. Searching: stable, and other attractors are searched. Neutral: no growth.
VERDICT_KINDS: Final = ("stable", "coexisting", "searching", "unstable", "neutral", "invalid")
# Phrases of headlines, and their short forms for narrow windows.
_SHORT_PHRASES: Final = (
    ("half peak-to-peak ", "±"),
    ("a limit cycle", "cycle"),
    ("growth rate", "growth"),
    (" (from the static start)", ""),
    (" (after a knock)", ""),
)


def shorten_headline(headline: str, width: int) -> str:
    """Shorten phrases of a headline until it fits a width."""
    for long, short in _SHORT_PHRASES:
        if cell_len(headline) > width:
            headline = headline.replace(long, short)
    return headline


class VerdictView(Vertical):
    """Headline, a few lines of facts, and gauges, with the scene's name in the border."""

    # The headline, then the facts.
    _lines: Sequence[str] = ("",)

    def compose(self) -> ComposeResult:
        """Headline, facts, gauges."""
        yield Static("", id="headline", markup=False)
        yield Static("", id="facts", markup=False)
        yield GaugeView(id="gauge")
        yield GaugeView(id="gauge-beside")

    def show(self, kind: str, lines: Sequence[str], gauges: Sequence[Gauge | str] = ()) -> None:
        """Display the headline, then the facts in `lines`, and up to two gauges.

        A text replaces a gauge that cannot be drawn. `kind` is one of `VERDICT_KINDS`.
        """
        self.set_class(len(gauges) > 1, "-beside")
        for view, gauge in zip(self.query(GaugeView), (*gauges, "", ""), strict=False):
            view.gauge = gauge
        bases = (gauge.basis for gauge in gauges if isinstance(gauge, Gauge))
        self.border_subtitle = next(bases, "")
        self._lines = lines
        for colour_kind in VERDICT_KINDS:
            self.set_class(colour_kind == kind, f"-{colour_kind}")
        self._fit_texts()

    @on(Resize)
    def _fit_texts(self) -> None:
        # A new layout at every key would be noticeably slow.
        width, facts_view = self.content_size.width, self.query_one("#facts", Static)
        first_line, *facts = self._lines
        headline = shorten_headline(first_line, width)
        if not facts_view.display:
            # `flow_facts` puts the first fact into the line of the headline if it fits.
            headline, _, _ = flow_facts([headline, *facts[:1]], width).partition("\n")
        facts_view.update(flow_facts(facts, width), layout=False)
        self.query_one("#headline", Static).update(headline, layout=False)
        # The headline takes two lines if it needs them and the facts still fit.
        self.set_class(cell_len(headline) > width and facts_view.size.height > 1, "-long")

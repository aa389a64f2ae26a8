"""A run beside measured data: inputs, overlay, spectra, verdict."""

from collections.abc import Callable

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Input, Static

from fivtui.model import InputError
from fivtui.transient import Transient
from fivtui.tui.chart import ChartView
from fivtui.tui.tabs.charts.measured import (
    INPUTS,
    overlay_chart,
    overlay_spectra,
    validation_of,
)

_FIRST_ROW = ("file", "time", "signal")
_PREFIX = "measured-"
_NOTHING = "no measured data: name a file above, Enter reads it"


class MeasuredView(Vertical):
    """Measured data beside the displayed run.

    `kept` gives the stored text of an input, `keep` stores it.
    """

    def __init__(
        self,
        id: str,  # noqa: A002
        kept: Callable[[str], str],
        keep: Callable[[str, str], None],
    ) -> None:
        super().__init__(id=id)
        self._kept, self._keep = kept, keep
        self._run: Transient | None = None

    def compose(self) -> ComposeResult:
        """Two rows of inputs, the charts, and a line of words."""
        for row in (_FIRST_ROW, tuple(name for name in INPUTS if name not in _FIRST_ROW)):
            with Horizontal(classes="bar"):
                for name in row:
                    yield Input(
                        self._kept(name),
                        id=f"{_PREFIX}{name}",
                        placeholder=INPUTS[name],
                        compact=True,
                        select_on_focus=False,
                    )
        yield ChartView("overlay-time", nothing=_NOTHING)
        yield ChartView("overlay-spectrum")
        yield Static("", id="overlay-words", markup=False)

    def show_run(self, run: Transient) -> None:
        """Compare a run with the measured data."""
        self._run = run
        self.draw()

    def draw(self) -> None:
        """Compare and draw; say what is wrong in the words below."""
        time, spectrum = self.query(ChartView)
        texts = {name: self.query_one(f"#{_PREFIX}{name}", Input).value.strip() for name in INPUTS}
        words = ""
        if self._run is None or not texts["file"]:
            time.show(None)
            spectrum.show(None)
        else:
            try:
                found = validation_of(self._run, texts)
            except InputError as error:
                words = str(error)
                time.show(None)
                spectrum.show(None)
            else:
                time.show(overlay_chart(found))
                spectrum.show(overlay_spectra(found))
                words = (
                    f"{found.t.size} samples, shift {found.shift:.5g} s, "
                    f"rms {found.rms:.4g} {found.unit}, at most {found.greatest:.4g} {found.unit}"
                )
        self.query_one("#overlay-words", Static).update(words)

    @on(Input.Changed)
    def _edited(self, event: Input.Changed) -> None:
        event.stop()
        self._keep(str(event.input.id).removeprefix(_PREFIX), event.value)

    @on(Input.Submitted)
    def _submitted(self, event: Input.Submitted) -> None:
        event.stop()
        for chart in self.query(ChartView):
            chart.view.reset()
        self.draw()

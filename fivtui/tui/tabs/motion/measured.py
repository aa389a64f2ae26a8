"""A run beside measured data: inputs, overlay, spectra, verdict."""

from collections.abc import Callable
from typing import Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Input, Static

from fivtui.measured import ValidateOptions, Validation
from fivtui.model import InputError
from fivtui.ranges import decimal_point
from fivtui.transient import Transient
from fivtui.tui.chart import ChartView, TextInput
from fivtui.tui.tabs.charts.measured import (
    INPUTS,
    NUMERIC,
    ROWS,
    check_input,
    comparison_words,
    options_of,
    overlay_chart,
    overlay_spectra,
    validation_of,
)

_PREFIX: Final = "measured-"
_NOTHING: Final = "no measured data: name a file above, Enter reads it"
# Rows for both plots below the inputs; with less only that over time is displayed.
_FOR_BOTH: Final = 14


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
        self._found: Validation | None = None
        self._words = ""

    def compose(self) -> ComposeResult:
        """Rows of inputs, the charts, and a line of words."""
        for row in ROWS:
            with Horizontal(classes="bar"):
                for name in row:
                    options = {"respell": decimal_point} if name in NUMERIC else {}
                    yield TextInput(
                        self._kept(name),
                        **options,
                        id=f"{_PREFIX}{name}",
                        placeholder=INPUTS[name][0],
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
        self._words, self._found = "", None
        if self._run is not None and self.texts["file"]:
            try:
                self._found = validation_of(self._run, self.texts)
            except InputError as error:
                self._words = str(error)
        found = self._found
        time.show(None if found is None else overlay_chart(found))
        spectrum.show(None if found is None else overlay_spectra(found))
        if found is not None:
            self._words = comparison_words(found)
        self.query_one("#overlay-words", Static).update(self._words)

    @property
    def texts(self) -> dict[str, str]:
        """The texts of the inputs by name."""
        return {name: self.query_one(f"#{_PREFIX}{name}", Input).value.strip() for name in INPUTS}

    @property
    def options(self) -> ValidateOptions:
        """The options of `fivtui validate` that say the same; `InputError` without a file."""
        if not self.texts["file"]:
            raise InputError(_NOTHING)
        return options_of(self.texts)

    @property
    def found(self) -> Validation:
        """The comparison; `InputError` if there is none."""
        if self._found is None:
            raise InputError(self._words or _NOTHING)
        return self._found

    @on(DescendantFocus)
    @on(DescendantBlur)
    def _say(self) -> None:
        # What the focused input means, or else what was found.
        focused = self.screen.focused
        name = "" if focused is None else str(focused.id).removeprefix(_PREFIX)
        words = INPUTS[name][1] if name in INPUTS else self._words
        self.query_one("#overlay-words", Static).update(self._error(name) or words)

    def _error(self, name: str) -> str:
        try:
            check_input(name, self.texts.get(name, ""))
        except InputError as error:
            return str(error)
        return ""

    def on_resize(self) -> None:
        """Show the spectra where there is room for both plots."""
        self.query_one("#overlay-spectrum").display = self.size.height >= _FOR_BOTH

    @on(Input.Changed)
    def _edited(self, event: Input.Changed) -> None:
        event.stop()
        name = str(event.input.id).removeprefix(_PREFIX)
        self._keep(name, event.value)
        event.input.set_class(bool(self._error(name)), "-invalid")
        self._say()

    @on(Input.Submitted)
    def _submitted(self, event: Input.Submitted) -> None:
        event.stop()
        for chart in self.query(ChartView):
            chart.view.reset()
        self.draw()

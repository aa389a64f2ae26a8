"""The view of a run beside measured data: their file, both signals, spectra, deviations."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Input

from fivtui.measured import (
    ValidateOptions,
    Validation,
    describe_verdict,
    overlay_chart,
    overlay_spectra,
    prepare_comparison,
)
from fivtui.model import InputError
from fivtui.transient import Transient
from fivtui.tui.chart import ChartView
from fivtui.tui.session import compute_outcome
from fivtui.tui.tabs.job_pane import FACTS, ActionBar, StatusLine
from fivtui.tui.tabs.option_input import ACCEPT_KEY, OptionInput, option_help, read_option_text
from fivtui.tui.tabs.pane import Pane
from fivtui.tui.tabs.preview import FILE_FORMAT, MEASURED_SKETCH, Preview

# The view, which is also the key of the stored text of its input; the key that goes there.
MEASURED: Final = "measured"
MEASURED_KEY: Final = "m"
_NO_DATA: Final = "no measured data: name a file above, Enter reads it"
_PLACEHOLDER: Final = "FILE.csv --signal NAME --scale N --shift auto --band 5%"
_FORMAT: Final = f"FILE.csv and options such as --band 5%; {ACCEPT_KEY}"


class MeasuredView(Vertical):
    """Measured data beside the displayed run."""

    def __init__(self) -> None:
        super().__init__(id=MEASURED, classes="-empty")
        self._run: Transient | None = None
        # The comparison that the last valid input asks for, and its result.
        self._compare: Callable[[Transient], Validation] | None = None
        self._validation: Validation | None = None
        # Error message of the input, or of the comparison.
        self._error = ""

    def compose(self) -> ComposeResult:
        """The input, the charts, and the verdict."""
        text = self.query_ancestor(Pane).stored_setting(MEASURED, "")
        with ActionBar():
            yield OptionInput(text, ValidateOptions, id="measured-data", placeholder=_PLACEHOLDER)
        yield ChartView("overlay-time")
        yield ChartView("overlay-spectrum")
        start = MEASURED_KEY, f"goes to the file above; Enter reads it. {FILE_FORMAT}"
        yield Preview(MEASURED_SKETCH, start)
        yield StatusLine()

    def show_run(self, run: Transient) -> None:
        """Compare a run with the measured data."""
        self._run = run
        self.draw()

    def draw(self) -> None:
        """Compare and draw; display the verdict or an error below."""
        self._validation, self._error = None, ""
        if self._run is not None and self._text:
            try:
                compare = prepare_comparison(self.options)()
                self._validation = compare(self._run)
                self._compare = compare
            except InputError as error:
                self._error = str(error)
                # The overlay stays until the input is corrected.
                if self._compare is not None:
                    self._validation = compute_outcome(partial(self._compare, self._run)).result
        validation = self._validation
        self.set_class(validation is None, "-empty")
        time_view, spectrum_view = self.query(ChartView)
        time_view.show(None if validation is None else overlay_chart(validation))
        spectrum_view.show(None if validation is None else overlay_spectra(validation))
        self._show_text()

    @property
    def _text(self) -> str:
        return self.query_one(OptionInput).value.strip()

    @property
    def options(self) -> ValidateOptions:
        """The input as options of `fivtui validate`; raises `InputError` without a file."""
        options, files = read_option_text(ValidateOptions, self._text)
        files += [] if options.measured is None else [options.measured]
        if len(files) != 1:
            raise InputError(f"{len(files)} files: must be one" if files else _NO_DATA)
        return replace(options, measured=files[0])

    @property
    def validation(self) -> Validation:
        """The comparison with measured data; raises `InputError` without a valid input."""
        if self._error or self._validation is None:
            raise InputError(self._error or _NO_DATA)
        return self._validation

    @on(DescendantFocus)
    @on(DescendantBlur)
    def _show_text(self) -> None:
        # The error of the input, the meaning of its last option while it is typed, or the verdict.
        data_input, result = self.query_one(OptionInput), self._validation
        is_error = bool(self._error)
        data_input.set_class(is_error, "-invalid")
        answer = text = ""
        if result is not None:
            warnings = [f"WARNING: {result.warning}"] if result.warning else []
            answer = FACTS.join([describe_verdict(result), *warnings])
            text = (
                f"rms {result.rms:.4g} {result.unit}, at most {result.greatest:.4g} {result.unit}; "
                f"{result.measurement.signal!r} as {result.quantity}, {result.t.size} samples, "
                f"shift {result.shift:.5g} s"
            )
        if data_input.has_focus:
            text = option_help(ValidateOptions, self._text, _FORMAT)
        status = self.query_one(StatusLine)
        status.show(None, "" if is_error else answer, self._error or text, is_error=is_error)

    @on(Input.Changed)
    def _store_input(self, event: Input.Changed) -> None:
        event.stop()
        self.query_ancestor(Pane).store_setting(MEASURED, event.value)
        outcome = compute_outcome(lambda: self._text and prepare_comparison(self.options))
        self._error = outcome.error
        self._show_text()

    @on(Input.Submitted)
    def _compare_inputs(self, event: Input.Submitted) -> None:
        event.stop()
        for chart in self.query(ChartView):
            chart.view.reset()
        self.draw()

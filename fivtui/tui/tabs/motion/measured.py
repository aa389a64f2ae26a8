"""The view of a run beside measured data: inputs, both signals, spectra, deviations."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.events import DescendantBlur, DescendantFocus
from textual.widgets import Input, Static

from fivtui.measured import (
    QUANTITIES,
    ValidateOptions,
    Validation,
    overlay_chart,
    overlay_spectra,
    prepare_comparison,
    read_shift,
    read_tolerances,
)
from fivtui.model import InputError, parse_number, unknown_name_error
from fivtui.ranges import with_decimal_point
from fivtui.transient import Transient
from fivtui.tui.chart import ChartView, TextInput
from fivtui.tui.tabs.preview import FILE_FORMAT, MEASURED_SKETCH, Preview

# Placeholder and meaning of the inputs by name. Apart from `file`, the names are those of options
# of `fivtui validate`.
_INPUTS: Final[Mapping[str, tuple[str, str]]] = {
    "file": ("FILE.csv", "file of measured data"),
    "time": ("time t", "name or number of the time column; if empty, t, time or the first"),
    "time-scale": ("t scale 1", "seconds per unit of the time column, e.g. 0.001 for ms"),
    "signal": ("signal y", "name or number of the signal column; if empty, the quantity"),
    "quantity": ("y", "what was measured: y, x, vy, vx or P, in SI units"),
    "scale": ("scale 1", "SI units per unit of the signal, e.g. 0.001 for mm"),
    "offset": ("offset 0", "added to the scaled signal, in SI units"),
    "shift": ("shift 0", "added to the measured times, s; auto: the shift of best correlation"),
    "band": ("band –", "half width of the band: in SI units, or % of half peak-to-peak"),
    "share": ("share 100%", "minimum share of the samples within the band"),
    "frequency": ("freq. –", "greatest deviation of the frequency, e.g. 2%"),
    "amplitude": ("ampl. –", "greatest deviation of half peak-to-peak, e.g. 5%"),
}
# Names of the inputs by row from the top.
_ROWS: Final = (
    ("file", "time", "time-scale", "signal"),
    ("quantity", "scale", "offset", "shift"),
    ("band", "share", "frequency", "amplitude"),
)
_NUMBERS: Final = ("scale", "offset", "time-scale")
_TOLERANCES: Final = ("band", "share", "frequency", "amplitude")
# Inputs of numbers, where a comma is a decimal comma.
_NUMERIC: Final = (*_NUMBERS, "shift", *_TOLERANCES)
_PREFIX: Final = "measured-"
_NO_DATA: Final = "no measured data: name a file above, Enter reads it"


class MeasuredView(Vertical):
    """Measured data beside the displayed run.

    `stored_text` returns the stored text of an input, `store_text` stores it. `bar_key` is the name
    of the key that goes to the inputs.
    """

    def __init__(
        self,
        id: str,  # noqa: A002
        stored_text: Callable[[str], str],
        store_text: Callable[[str, str], None],
        bar_key: str,
    ) -> None:
        super().__init__(id=id, classes="-empty")
        self._stored_text, self._store_text = stored_text, store_text
        self._bar_key = bar_key
        self._run: Transient | None = None
        self._validation: Validation | None = None
        self._result_text = ""

    def compose(self) -> ComposeResult:
        """Rows of inputs, the charts, and a line of text."""
        for row in _ROWS:
            with Horizontal(classes="bar"):
                for name in row:
                    options = {"replace_commas": with_decimal_point} if name in _NUMERIC else {}
                    placeholder, _ = _INPUTS[name]
                    yield TextInput(
                        self._stored_text(name),
                        **options,
                        id=f"{_PREFIX}{name}",
                        placeholder=placeholder,
                        compact=True,
                        select_on_focus=False,
                    )
        yield ChartView("overlay-time")
        yield ChartView("overlay-spectrum")
        yield Preview(
            MEASURED_SKETCH,
            "How near does the model come to a measurement?",
            (self._bar_key, f"goes to the file above; Enter reads it. {FILE_FORMAT}"),
        )
        yield Static("", id="overlay-text", markup=False)

    def show_run(self, run: Transient) -> None:
        """Compare a run with the measured data."""
        self._run = run
        self.draw()

    def draw(self) -> None:
        """Compare and draw; display the result or an error below."""
        time_view, spectrum_view = self.query(ChartView)
        self._result_text, self._validation = "", None
        if self._run is not None and self.texts["file"]:
            try:
                # In messages, the names of inputs have no prefix, as options have.
                compare = prepare_comparison(self.options, prefix="")
                self._validation = compare(self._run)
            except InputError as error:
                self._result_text = str(error)
        validation = self._validation
        self.set_class(validation is None, "-empty")
        time_view.show(None if validation is None else overlay_chart(validation))
        spectrum_view.show(None if validation is None else overlay_spectra(validation))
        if validation is not None:
            self._result_text = _comparison_text(validation)
        self._update_text(self._result_text)

    @property
    def texts(self) -> dict[str, str]:
        """The texts of the inputs by name."""
        return {name: self.query_one(f"#{_PREFIX}{name}", Input).value.strip() for name in _INPUTS}

    @property
    def options(self) -> ValidateOptions:
        """The inputs as options of `fivtui validate`; raises `InputError` without a file."""
        if not self.texts["file"]:
            raise InputError(_NO_DATA)
        return _read_options(self.texts)

    @property
    def validation(self) -> Validation:
        """The comparison with measured data; raises `InputError` if there is none."""
        if self._validation is None:
            raise InputError(self._result_text or _NO_DATA)
        return self._validation

    @on(DescendantFocus)
    @on(DescendantBlur)
    def _show_help(self) -> None:
        # The meaning of the focused input, or else the result.
        focused = self.screen.focused
        name = "" if focused is None else str(focused.id).removeprefix(_PREFIX)
        _, meaning = _INPUTS.get(name, ("", ""))
        text = meaning or self._result_text
        self._update_text(self._input_error(name) or text)

    def _update_text(self, text: str) -> None:
        self.query_one("#overlay-text", Static).update(text)
        # A result without warning has one line where rows are few.
        is_plain = self._validation is not None and not self._validation.warning
        self.set_class(is_plain and text == self._result_text, "-brief")

    def _input_error(self, name: str) -> str:
        try:
            _check_input(name, self.texts.get(name, ""))
        except InputError as error:
            return str(error)
        return ""

    @on(Input.Changed)
    def _store_input(self, event: Input.Changed) -> None:
        event.stop()
        name = str(event.input.id).removeprefix(_PREFIX)
        self._store_text(name, event.value)
        event.input.set_class(bool(self._input_error(name)), "-invalid")
        self._show_help()

    @on(Input.Submitted)
    def _compare_inputs(self, event: Input.Submitted) -> None:
        event.stop()
        for chart in self.query(ChartView):
            chart.view.reset()
        self.draw()


def _check_input(name: str, text: str) -> None:
    """Raise `InputError` if the text of an input is invalid for any file and any run."""
    if not text:
        return
    if name in _NUMBERS:
        parse_number(name, text, "a number")
    elif name == "shift":
        read_shift(text)
    elif name == "quantity" and text not in QUANTITIES:
        raise unknown_name_error(name, text, QUANTITIES)
    elif name in _TOLERANCES:
        # A share is valid only together with a band, for which any valid text will do.
        read_tolerances({name: text} if name == "band" else {"band": "1", name: text})


def _comparison_text(result: Validation) -> str:
    """The compared quantities and the deviation."""
    warning, unit = f"WARNING: {result.warning}; " if result.warning else "", result.unit
    return (
        f"{warning}rms {result.rms:.4g} {unit}, at most {result.greatest:.4g} {unit}; "
        f"{result.measurement.signal!r} as {result.quantity}, {result.t.size} samples, "
        f"shift {result.shift:.5g} s"
    )


def _read_options(texts: Mapping[str, str]) -> ValidateOptions:
    """The options of `fivtui validate` with the values of the inputs."""
    values: dict[str, Any] = {
        name.replace("-", "_"): text for name, text in texts.items() if text and name != "file"
    }
    return ValidateOptions(measured=Path(texts["file"]).expanduser(), **values)

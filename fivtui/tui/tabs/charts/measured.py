"""A run beside measured data as charts. Imports no Textual."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal

from fivtui.charts import Chart, Guide, Trace
from fivtui.measured import (
    QUANTITIES,
    Criterion,
    ValidateOptions,
    Validation,
    read_measurement,
    read_tolerances,
    validate,
)
from fivtui.model import parse_number, unknown_name
from fivtui.transient import Transient

from .transient import TIME_LABEL, contact_strips, label_of

# Inputs of the view, by the names of options of `fivtui validate` but the first: what they say
# where they are empty, and what they mean.
INPUTS: Final[Mapping[str, tuple[str, str]]] = {
    "file": ("FILE.csv", "file of measured data"),
    "time": ("time t", "column of the times, by name or number; t, time or the first if empty"),
    "time-scale": ("t scale 1", "seconds in a unit of the time column, e.g. 0.001 for ms"),
    "signal": ("signal y", "column of the signal, by name or number; as the quantity if empty"),
    "quantity": ("y", "what was measured: y, x, vy, vx or P, in SI units"),
    "scale": (
        "scale 1",
        "SI units in a unit of the signal, e.g. 0.001 for mm",
    ),
    "offset": ("offset 0", "added to the scaled signal, in SI units"),
    "shift": ("shift 0", "added to the measured times, s; auto: where both correlate best"),
    "band": ("band –", "half width of the band: in SI units, or % of half peak-to-peak"),
    "share": ("share 100%", "samples that must be within the band"),
    "frequency": ("freq. –", "greatest deviation of the frequency, e.g. 2%"),
    "amplitude": ("ampl. –", "greatest deviation of half peak-to-peak, e.g. 5%"),
}
# By row from the top.
ROWS: Final = (
    ("file", "time", "time-scale", "signal"),
    ("quantity", "scale", "offset", "shift"),
    ("band", "share", "frequency", "amplitude"),
)
_NUMBERS: Final = ("scale", "offset", "time-scale")
_TOLERANCES: Final = ("band", "share", "frequency", "amplitude")
# Inputs of numbers, where a comma is a decimal comma.
NUMERIC: Final = (*_NUMBERS, "shift", *_TOLERANCES)
_HARMONICS: Final = 8.0


def validation_of(run: Transient, texts: Mapping[str, str]) -> Validation:
    """A run compared with the file that the texts of the inputs name.

    Raises `InputError` if an input is wrong, or there is nothing to compare.
    """
    numbers = {
        name.replace("-", "_"): parse_number(name, texts[name], "a number")
        for name in _NUMBERS
        if texts[name]
    }
    path, quantity = Path(texts["file"]).expanduser(), texts["quantity"] or "y"
    measurement = read_measurement(
        path, time=texts["time"], signal=texts["signal"], quantity=quantity, **numbers
    )
    return validate(
        run,
        measurement,
        quantity=quantity,
        shift=_shift(texts["shift"]),
        tolerances=read_tolerances(texts),
    )


def _shift(text: str) -> float | Literal["auto"]:
    return "auto" if text == "auto" else parse_number("shift", text or 0.0, "s, or auto")


def check_input(name: str, text: str) -> None:
    """Raise `InputError` if the text of an input is wrong whatever the file and the run are."""
    if not text:
        return
    if name in _NUMBERS:
        parse_number(name, text, "a number")
    elif name == "shift":
        _shift(text)
    elif name == "quantity" and text not in QUANTITIES:
        raise unknown_name(name, text, QUANTITIES)
    elif name in _TOLERANCES:
        # A share needs a band.
        read_tolerances({"band": "1", name: text})


def comparison_words(result: Validation) -> str:
    """What was compared with what, and the deviation."""
    warning = f"WARNING: {result.warning}; " if result.warning else ""
    return (
        f"{warning}{result.measurement.signal!r} as {result.quantity}, {result.t.size} samples, "
        f"shift {result.shift:.5g} s, "
        f"rms {result.rms:.4g} {result.unit}, at most {result.greatest:.4g} {result.unit}"
    )


def options_of(texts: Mapping[str, str]) -> ValidateOptions:
    """The options of `fivtui validate` that say what the inputs do."""
    values: dict[str, Any] = {
        name.replace("-", "_"): text for name, text in texts.items() if text and name != "file"
    }
    return ValidateOptions(measured=Path(texts["file"]) if texts["file"] else None, **values)


def overlay_chart(found: Validation) -> Chart:
    """Measured and computed signal over time, with the edges of the tolerance band."""
    traces = [
        Trace("computed", found.t, found.computed),
        Trace("measured", found.t, found.measured),
    ]
    if found.band is not None:
        for name, side in (("band", 1.0), ("", -1.0)):
            edge = found.computed + side * found.band
            traces.insert(0, Trace(name, found.t, edge, look="dots", colour="#808080"))
    return Chart(
        TIME_LABEL,
        label_of(found.quantity),
        tuple(traces),
        strips=contact_strips(
            found.separated, None if found.parameters.v_belt is None else found.stuck
        ),
        note=verdict_words(found),
    )


def overlay_spectra(found: Validation) -> Chart:
    """Spectra of both signals."""
    measured, computed = found.spectra
    base = max(measured.fundamental, computed.fundamental)
    top = float(measured.frequency[-1])
    guides = (Guide(measured.fundamental, "f₁"),) if measured.fundamental > 0.0 else ()
    return Chart(
        "f (Hz)",
        f"|{found.quantity}| ({found.unit})",
        (
            Trace("computed", computed.frequency, computed.amplitude),
            Trace("measured", measured.frequency, measured.amplitude),
        ),
        guides=guides,
        note=f"f₁ {measured.fundamental:.4g} Hz measured, {computed.fundamental:.4g} Hz computed",
        x_range=(0.0, min(top, _HARMONICS * base) if base > 0.0 else top),
    )


def verdict_words(found: Validation) -> str:
    """Whether the run passes, in a few words."""
    if not found.criteria:
        return f"rms {found.rms:.3g}, correlation {found.correlation:.3f}"
    return f"{'PASS' if found.passed else 'FAIL'}: {'; '.join(map(_criterion, found.criteria))}"


def _criterion(criterion: Criterion) -> str:
    # What is asked of shares is a least value, of deviations a greatest.
    least = criterion.name.startswith("share")
    asked = f"at {'least' if least else 'most'} {criterion.limit:.3%}"
    return f"{criterion.name} {criterion.found:.3%}, {asked}"

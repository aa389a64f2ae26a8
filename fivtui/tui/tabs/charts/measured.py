"""A run beside measured data as charts. Imports no Textual."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fivtui.measured import (
    Tolerances,
    Validation,
    read_measurement,
    read_tolerance,
    validate,
)
from fivtui.model import parse_number
from fivtui.transient import Transient
from fivtui.tui.chart import Chart, Guide, Trace

from .transient import TIME_LABEL, contact_strips, label_of

# Inputs of the view by name, with what they say where they are empty.
INPUTS: Final[Mapping[str, str]] = {
    "file": "FILE.csv of measured data",
    "time": "time column",
    "signal": "signal column",
    "quantity": "y, x, vy, vx or P",
    "scale": "scale 1",
    "offset": "offset 0",
    "shift": "shift 0 or auto",
    "band": "band 0.1 or 5%",
}
_HARMONICS: Final = 8.0


def validation_of(run: Transient, texts: Mapping[str, str]) -> Validation:
    """A run compared with the file that the texts of the inputs name.

    Raises `InputError` if an input is wrong, or there is nothing to compare.
    """
    numbers = {
        name: parse_number(name, texts[name], "a number")
        for name in ("scale", "offset")
        if texts[name]
    }
    measurement = read_measurement(
        Path(texts["file"]).expanduser(), time=texts["time"], signal=texts["signal"], **numbers
    )
    shift, band = texts["shift"], texts["band"]
    return validate(
        run,
        measurement,
        quantity=texts["quantity"] or "y",
        shift="auto" if shift == "auto" else parse_number("shift", shift or 0.0, "s, or auto"),
        tolerances=Tolerances(read_tolerance("band", band)) if band else None,
    )


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
        "f / Hz",
        f"|{found.quantity}| / {found.unit}",
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
    share = found.criteria[0].found
    return f"{'PASS' if found.passed else 'FAIL'}: {share:.1%} within ±{found.band:.3g}"

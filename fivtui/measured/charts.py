"""Charts of a run beside measured data: both signals over time, and their spectra."""

from fivtui.charts import Chart, Guide, Trace
from fivtui.signals import frequency_range
from fivtui.transient import TIME_LABEL, column_label, contact_strips

from .comparison import Criterion, Validation


def overlay_chart(result: Validation) -> Chart:
    """Measured and computed signal over time, with the edges of the tolerance band."""
    traces = [
        Trace("computed", result.t, result.computed),
        Trace("measured", result.t, result.measured),
    ]
    if result.band is not None:
        for name, side in (("band", 1.0), ("", -1.0)):
            edge = result.computed + side * result.band
            traces.insert(0, Trace(name, result.t, edge, look="dots", colour="#808080"))
    return Chart(
        TIME_LABEL,
        column_label(result.quantity),
        tuple(traces),
        strips=contact_strips(
            result.separated, None if result.parameters.v_belt is None else result.stuck
        ),
        note=verdict_words(result),
    )


def overlay_spectra(result: Validation) -> Chart:
    """Spectra of both signals."""
    measured, computed = result.spectra
    guides = (Guide(measured.fundamental, "f₁"),) if measured.fundamental > 0.0 else ()
    return Chart(
        "f (Hz)",
        f"|{result.quantity}| ({result.unit})",
        (
            Trace("computed", computed.frequency, computed.amplitude),
            Trace("measured", measured.frequency, measured.amplitude),
        ),
        guides=guides,
        note=f"f₁ {measured.fundamental:.4g} Hz measured, {computed.fundamental:.4g} Hz computed",
        x_range=frequency_range(measured, computed),
    )


def verdict_words(result: Validation) -> str:
    """Whether the run passes, in a few words."""
    if not result.criteria:
        return f"rms {result.rms:.3g}, correlation {result.correlation:.3f}"
    return f"{'PASS' if result.passed else 'FAIL'}: {'; '.join(map(_criterion, result.criteria))}"


def _criterion(criterion: Criterion) -> str:
    # Shares have a lower limit, deviations an upper limit.
    bound = "least" if criterion.name.startswith("share") else "most"
    return f"{criterion.name} {criterion.found:.3%}, at {bound} {criterion.limit:.3%}"

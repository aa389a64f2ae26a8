"""Charts of a comparison: measured and computed signal over time, and their spectra."""

from dataclasses import replace
from typing import Final

import numpy as np

from fivtui.charts import CASE_COLOURS, FIGURE_WIDTH, Chart, Guide, Label, Sheet, Trace, math_symbol
from fivtui.signals import frequency_range
from fivtui.transient import TIME_LABEL, column_label, contact_strips

from .comparison import Criterion, FloatArray, Validation

# Width and height of the figure in inches, and relative heights of its three charts.
_SIZE: Final = (FIGURE_WIDTH, 5.6)
_HEIGHTS: Final = (1.6, 1.0, 1.2)
# Range of amplitudes in figures of spectra, relative to the greatest.
_AMPLITUDE_RANGE: Final = (1e-4, 2.0)


def overlay_chart(result: Validation) -> Chart:
    """Measured and computed signal over time, with the edges of the tolerance band.

    Strips, rows of intervals below the chart, mark separation and stick.
    """
    traces = [
        Trace("computed", result.t, result.computed, role="computed"),
        Trace("measured", result.t, result.measured, role="measured"),
    ]
    if result.band is not None:
        for name, offset in (("+band", result.band), ("−band", -result.band)):
            edge = result.computed + offset
            traces.insert(0, Trace(name, result.t, edge, look="dots", colour="reference"))
    return Chart(
        TIME_LABEL,
        column_label(result.quantity),
        tuple(traces),
        strips=contact_strips(
            result.separated, None if result.parameters.v_belt is None else result.stuck
        ),
    )


def overlay_spectra(result: Validation) -> Chart:
    """Spectra of both signals."""
    measured, computed = result.spectra
    guides = (Guide(measured.fundamental, "f₁"),) if measured.fundamental > 0.0 else ()
    return Chart(
        Label("f (Hz)", math="Frequency $f$ (Hz)"),
        Label(
            f"|{result.quantity}| ({result.unit})",
            math=f"Amplitude\nof {math_symbol(result.quantity)} ({result.unit})",
        ),
        (
            Trace("computed", computed.frequency, computed.amplitude, role="computed"),
            Trace("measured", measured.frequency, measured.amplitude, role="measured"),
        ),
        guides=guides,
        note=f"f₁ {measured.fundamental:.4g} Hz measured, {computed.fundamental:.4g} Hz computed",
        x_range=frequency_range(measured, computed),
    )


def validation_sheet(result: Validation) -> Sheet:
    """Both signals over time with the tolerance band, their deviation, and their spectra."""
    colour, *_ = CASE_COLOURS[result.separation]
    # Limits of the time axis in figures; the `x_range` of a chart applies to the terminal, too.
    span = (float(result.t[0]), float(result.t[-1]))

    def signals_alone(chart: Chart) -> Chart:
        # The chart without band and guides. The colour of the computed signal tells whether
        # separation is considered.
        *_, computed, measured = chart.traces
        return replace(chart, traces=(replace(computed, colour=colour), measured), guides=())

    def band_around(values: FloatArray) -> tuple[Trace, ...]:
        # The tolerance band as an area; none without a band.
        if result.band is None:
            return ()
        x = np.concatenate([result.t, result.t[::-1]])
        y = np.concatenate([values - result.band, values[::-1] + result.band])
        return (
            Trace("tolerance band", x, y, "area", ordered=False, colour=colour, role="tolerance"),
        )

    signals = signals_alone(overlay_chart(result))
    over_time = replace(
        signals,
        traces=(*band_around(result.computed), *signals.traces),
        title=_verdict_text(result, result.measurement.signal) if result.criteria else "",
        x_axis=False,
        figure_x=span,
    )
    deviation = Chart(
        TIME_LABEL,
        f"measured\n− computed ({result.unit})",
        (
            *band_around(np.zeros(result.t.size)),
            Trace("", result.t, result.measured - result.computed, role="deviation"),
        ),
        strips=signals.strips,
        figure_x=span,
    )
    spectra = signals_alone(overlay_spectra(result))
    greatest = max(float(entry.amplitude.max()) for entry in result.spectra)
    low, high = (share * greatest for share in _AMPLITUDE_RANGE)
    spectra = replace(
        spectra,
        log="y",
        figure_x=spectra.x_range or (None, None),
        figure_y=(low, high) if greatest > 0.0 else (None, None),
    )
    return Sheet([[over_time, deviation, spectra]], _SIZE, heights=_HEIGHTS)


def describe_verdict(result: Validation) -> str:
    """The verdict in one line, or the correlation without criteria."""
    if not result.criteria:
        return f"correlation {result.correlation:.3f}"
    return _verdict_text(result, "; ".join(map(_criterion_text, result.criteria)))


def _verdict_text(result: Validation, detail: str) -> str:
    return f"{'PASS' if result.passed else 'FAIL'}: {detail}"


def _criterion_text(criterion: Criterion) -> str:
    # Shares have a lower limit, deviations an upper limit.
    bound = "least" if criterion.name.startswith("share") else "most"
    return f"{criterion.name} {criterion.found:.3%}, at {bound} {criterion.limit:.3%}"

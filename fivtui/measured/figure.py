"""A run beside measured data as a figure."""

import matplotlib as mpl
from matplotlib.figure import Figure

from fivtui.charts import (
    CASE_COLOURS,
    OFF_BELT,
    STUCK,
    STYLE,
    WIDTH,
    math_symbol,
    math_unit,
    new_figure,
    shade_times,
)

from .comparison import Validation

_HARMONICS = 6.0
_MEASURED = "#c2410c"


def validation_figure(result: Validation) -> Figure:
    """Both signals over time with the tolerance band, their deviation, and their spectra."""
    with mpl.rc_context(STYLE):
        figure = new_figure(WIDTH, 5.6)
        over_time, apart, lines = figure.subplots(3, 1, height_ratios=(1.6, 1.0, 1.2))
        colour = CASE_COLOURS[result.separation][0]
        symbol, unit = math_symbol(result.quantity), math_unit(result.unit)
        t, band = result.t, result.band
        if band is not None:
            over_time.fill_between(
                t,
                result.computed - band,
                result.computed + band,
                color=colour,
                alpha=0.18,
                linewidth=0.0,
                label="tolerance band",
            )
            apart.axhspan(-band, band, color=colour, alpha=0.18, linewidth=0.0)
        over_time.plot(t, result.computed, color=colour, linewidth=1.1, label="computed")
        over_time.plot(
            t, result.measured, color=_MEASURED, linewidth=0.9, linestyle="--", label="measured"
        )
        over_time.set_ylabel(f"{symbol} ({unit})")
        apart.plot(t, result.measured - result.computed, color="0.25", linewidth=0.8)
        apart.set_ylabel(f"measured − computed ({unit})".replace(" − ", "\n− "))
        apart.set_xlabel("$t$ (s)")
        apart.sharex(over_time)
        for axes in (over_time, apart):
            shade_times(axes, result.separated, OFF_BELT, "off the belt")
            shade_times(axes, result.stuck, STUCK, "stuck to the belt")
        over_time.set_xlim(t[0], t[-1])
        over_time.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, frameon=False)
        measured, computed = result.spectra
        lines.plot(computed.frequency, computed.amplitude, color=colour, linewidth=1.1)
        lines.plot(
            measured.frequency, measured.amplitude, color=_MEASURED, linewidth=0.9, linestyle="--"
        )
        lines.set_yscale("log")
        top = _HARMONICS * max(measured.fundamental, computed.fundamental)
        lines.set_xlim(0.0, min(top, measured.frequency[-1]) if top > 0.0 else None)
        greatest = max(measured.amplitude.max(), computed.amplitude.max())
        if greatest > 0.0:
            lines.set_ylim(1e-4 * greatest, 2.0 * greatest)
        lines.set_xlabel("frequency (Hz)")
        lines.set_ylabel(f"amplitude ({unit})")
        if result.passed is not None:
            verdict = "PASS" if result.passed else "FAIL"
            figure.suptitle(f"{verdict}: {result.measurement.signal}", parse_math=False)
    return figure

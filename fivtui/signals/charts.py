"""Charts of spectra."""

from collections.abc import Sequence
from typing import Final

from fivtui.charts import Chart, Guide
from fivtui.transient import PlottedRun, window_text

from .spectra import Spectrum, spectrum

# The frequency axis ends at this harmonic; guides mark the first harmonics.
_SHOWN_HARMONICS: Final = 8.0
_MARKED_HARMONICS: Final = 3


def spectrum_chart(runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """Spectra of y within a time window, with the first harmonics of the first run marked."""
    spectra = []
    for run in runs:
        samples = run.samples_in(window)
        spectra.append(spectrum(run.trajectory.t[samples], run.trajectory.y[samples]))
    fundamental, note = spectra[0].fundamental, f"{window_text(window)}, no vibration"
    guides: tuple[Guide, ...] = ()
    if fundamental > 0.0:
        guides = tuple(
            Guide(number * fundamental, "f₁" if number == 1 else f"{number}f₁")
            for number in range(1, _MARKED_HARMONICS + 1)
        )
        note = f"f₁ {fundamental:.4g} Hz, period {1.0 / fundamental:.4g} s, {window_text(window)}"
    return Chart(
        "f (Hz)",
        "|y| (m)",
        # The first run comes last, so that it is drawn on top.
        tuple(
            run.trace(line_spectrum.frequency, line_spectrum.amplitude)
            for run, line_spectrum in reversed(list(zip(runs, spectra, strict=True)))
        ),
        guides=guides,
        note=note,
        x_range=frequency_range(spectra[0]),
    )


def frequency_range(*spectra: Spectrum) -> tuple[float, float]:
    """The range from 0 to the eighth harmonic, Hz; all frequencies without a fundamental."""
    fundamental = max(line_spectrum.fundamental for line_spectrum in spectra)
    max_frequency = float(spectra[0].frequency[-1])
    if fundamental > 0.0:
        return 0.0, min(max_frequency, _SHOWN_HARMONICS * fundamental)
    return 0.0, max_frequency

"""Charts of spectra."""

from collections.abc import Sequence
from typing import Final

from fivtui.charts import Chart, Guide
from fivtui.transient import PlottedRun, window_text

from .spectra import Spectrum, spectrum

# Harmonics displayed, and marked.
_HARMONICS: Final = 8.0
_MARKED: Final = 3


def spectrum_chart(runs: Sequence[PlottedRun], window: tuple[float, float]) -> Chart:
    """Spectra of y within a time window, with the first harmonics of the first run marked."""
    parts = [(run.trajectory, run.samples_in(window)) for run in runs]
    spectra = [spectrum(motion.t[part], motion.y[part]) for motion, part in parts]
    first = spectra[0]
    base, note = first.fundamental, f"{window_text(window)}, no vibration"
    guides: tuple[Guide, ...] = ()
    if base > 0.0:
        guides = tuple(
            Guide(number * base, "f₁" if number == 1 else f"{number}f₁")
            for number in range(1, _MARKED + 1)
        )
        note = f"f₁ {base:.4g} Hz, period {1.0 / base:.4g} s, {window_text(window)}"
    return Chart(
        "f (Hz)",
        "|y| (m)",
        tuple(
            run.trace(lines.frequency, lines.amplitude)
            for run, lines in reversed(list(zip(runs, spectra, strict=True)))
        ),
        guides=guides,
        note=note,
        x_range=frequency_range(first),
    )


def frequency_range(*spectra: Spectrum) -> tuple[float, float]:
    """From 0 to a harmonic of the highest fundamental frequency, Hz; without one, all."""
    base, top = max(lines.fundamental for lines in spectra), float(spectra[0].frequency[-1])
    return 0.0, min(top, _HARMONICS * base) if base > 0.0 else top

"""Amplitude spectra."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError

FloatArray = NDArray[np.float64]

_MIN_SAMPLES: Final = 16
# Lower limit of amplitudes before their logarithm is taken.
_MIN_AMPLITUDE: Final = 1e-300
# Relative amplitude below which a spectrum contains only rounding errors.
_ROUNDING: Final = 1e-10
# Allowed relative difference between sample steps, as times in files are rounded.
_STEP_TOLERANCE: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Amplitudes over frequency.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Frequencies from 0, Hz, ascending.
    amplitude : ndarray, shape (n,)
        Amplitude of the sine of each frequency; at 0 the absolute mean.
    fundamental : float
        Frequency of the largest amplitude besides the mean, Hz; 0 without vibration.
    resolution : float
        Spacing of resolved frequencies, Hz.
    """

    frequency: FloatArray
    amplitude: FloatArray
    fundamental: float
    resolution: float

    @property
    def period(self) -> float | None:
        """1 / fundamental frequency, s; None without vibration."""
        return 1.0 / self.fundamental if self.fundamental > 0.0 else None


def spectrum(t: FloatArray, values: FloatArray) -> Spectrum:
    """The amplitude spectrum of an evenly sampled signal, with a Hann window.

    The window applies to the signal without its mean; the amplitude at 0 is that of the mean. A
    parabola through the logarithms of the largest amplitude and its neighbours gives the
    fundamental frequency. A last step that is shorter than the others is ignored.
    """
    if t.size > 1 and t[-1] - t[-2] < (1.0 - _STEP_TOLERANCE) * (t[1] - t[0]):
        t, values = t[:-1], values[:-1]
    if t.size < _MIN_SAMPLES:
        raise InputError(f"spectrum: {t.size} samples; must be at least {_MIN_SAMPLES}")
    step = float(t[-1] - t[0]) / (t.size - 1)
    if np.abs(np.diff(t) - step).max() > _STEP_TOLERANCE * step:
        raise InputError("spectrum: the samples are not evenly spaced")
    mean = float(values.mean())
    # A periodic window: its spectral lines lie on frequencies of the transform.
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(t.size) / t.size)
    transform = np.fft.rfft((values - mean) * window)
    amplitude: FloatArray = np.hypot(transform.real, transform.imag) * (2.0 / window.sum())
    amplitude[0] = abs(mean)
    resolution = 1.0 / (step * t.size)
    frequency = resolution * np.arange(transform.size, dtype=np.float64)
    return Spectrum(frequency, amplitude, _fundamental(amplitude, values) * resolution, resolution)


def _fundamental(amplitude: FloatArray, values: FloatArray) -> float:
    # Fundamental frequency in units of the resolution; 0 without vibration. A parabola through the
    # logarithms of three amplitudes locates the peak between the resolved frequencies.
    peak = 1 + int(amplitude[1:].argmax())
    scale = float(np.abs(values).max())
    if amplitude[peak] <= _ROUNDING * scale:
        return 0.0
    if peak + 1 >= amplitude.size or peak == 1:
        return float(peak)
    below, top, above = np.log(np.maximum(amplitude[peak - 1 : peak + 2], _MIN_AMPLITUDE)).tolist()
    curvature = below - 2.0 * top + above
    return peak + (0.5 * (below - above) / curvature if curvature < 0.0 else 0.0)

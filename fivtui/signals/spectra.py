"""Amplitude spectra."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import InputError

FloatArray = NDArray[np.float64]

_FEWEST: Final = 16
# Smaller relative amplitudes are rounding.
_NOISE: Final = 1e-10
# Relative difference of sample steps: the times are rounded decimals.
_UNEVEN: Final = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Amplitudes over frequency.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Hz, ascending from 0.
    amplitude : ndarray, shape (n,)
        Amplitude of each frequency's sine; at 0 the mean.
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

    The mean is removed first and put at frequency 0. The fundamental frequency is interpolated by a
    parabola through the logarithms of the highest line and its neighbours. A shorter last step is
    dropped.
    """
    if t.size > 1 and t[-1] - t[-2] < (1.0 - _UNEVEN) * (t[1] - t[0]):
        t, values = t[:-1], values[:-1]
    if t.size < _FEWEST:
        raise InputError(f"spectrum: {t.size} samples; must be at least {_FEWEST}")
    step = float(t[-1] - t[0]) / (t.size - 1)
    if np.abs(np.diff(t) - step).max() > _UNEVEN * step:
        raise InputError("spectrum: the samples are not evenly spaced")
    mean = float(values.mean())
    # A periodic window: its spectral lines lie on frequencies of the transform.
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(t.size) / t.size)
    lines = np.fft.rfft((values - mean) * window)
    amplitude: FloatArray = np.hypot(lines.real, lines.imag) * (2.0 / window.sum())
    amplitude[0] = abs(mean)
    resolution = 1.0 / (step * t.size)
    frequency = resolution * np.arange(lines.size, dtype=np.float64)
    return Spectrum(frequency, amplitude, _fundamental(amplitude, values) * resolution, resolution)


def _fundamental(amplitude: FloatArray, values: FloatArray) -> float:
    # Fundamental frequency in units of the resolution.
    highest = 1 + int(amplitude[1:].argmax())
    size = float(np.abs(values).max())
    if amplitude[highest] <= _NOISE * size:
        return 0.0
    if highest + 1 >= amplitude.size or highest == 1:
        return float(highest)
    below, top, above = np.log(np.maximum(amplitude[highest - 1 : highest + 2], 1e-300)).tolist()
    bend = below - 2.0 * top + above
    return highest + (0.5 * (below - above) / bend if bend < 0.0 else 0.0)

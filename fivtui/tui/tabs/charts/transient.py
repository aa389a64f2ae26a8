"""The charts of a transient: motion over time, phase portraits, spectrum. Imports no Textual."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model.errors import InputError
from fivtui.model.slider_belt import Mode
from fivtui.transient.result import Transient
from fivtui.transient.trajectory import COLUMNS, Trajectory
from fivtui.tui.chart.chart import Chart, Guide, Trace

FloatArray = NDArray[np.float64]

SYMBOLS: Final = {"vx": "ẋ", "vy": "ẏ"}
_UNITS: Final = {column.name: column.unit for column in COLUMNS}
TIME_LABEL: Final = "t / s"
# Harmonics that the spectrum shows, and those that are marked.
_HARMONICS: Final = 8.0
_MARKED: Final = 3
_FEWEST: Final = 16
# Amplitudes below this part of the greatest are rounding.
_NOISE: Final = 1e-10
# Steps of the samples may differ by this part: they are decimal numbers.
_UNEVEN: Final = 1e-3


def label_of(quantity: str) -> str:
    """Symbol and unit of a column of a trajectory."""
    return f"{SYMBOLS.get(quantity, quantity)} / {_UNITS[quantity]}"


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A trajectory and how it is drawn.

    Attributes
    ----------
    name : str
        What tells it from others.
    trajectory : Trajectory
        Its samples.
    separated : sequence of (start, end)
        When it is off the belt, s.
    t_end : float
        The horizon, s.
    mark, colour : str
        See `Trace`.
    """

    name: str
    trajectory: Trajectory
    separated: Sequence[tuple[float, float]]
    t_end: float
    mark: str = ""
    colour: str = ""


def motion_of(result: Transient, name: str = "", mark: str = "", colour: str = "") -> Motion | None:
    """The motion of a result.

    Parameters
    ----------
    result : Transient
        The result.
    name, mark, colour : str
        See `Motion`.

    Returns
    -------
    Motion or None
        None if it was computed without sample times.
    """
    if result.trajectory is None:
        return None
    separated = result.separated_intervals
    return Motion(name, result.trajectory, separated, result.t_end, mark, colour)


def separated_samples(trajectory: Trajectory) -> list[tuple[float, float]]:
    """When a trajectory is off the belt, as far as its samples tell.

    Parameters
    ----------
    trajectory : Trajectory
        At least one sample.

    Returns
    -------
    list of (start, end)
        From the first separated sample to the first one in contact again, s.
    """
    off = np.concatenate(([False], trajectory.mode == Mode.SEPARATED, [False]))
    changes = np.flatnonzero(np.diff(off))
    times = np.append(trajectory.t, trajectory.t[-1])[changes].tolist()
    return list(zip(times[::2], times[1::2], strict=True))


def time_chart(quantity: str, motions: Sequence[Motion], *, strip: bool, x_axis: bool) -> Chart:
    """A quantity over time.

    Parameters
    ----------
    quantity : str
        A column of the trajectory.
    motions : sequence of Motion
        At least one; the first is that whose separated intervals are marked.
    strip, x_axis : bool
        Whether to mark them, and whether to label the ticks of the time axis.

    Returns
    -------
    Chart
        A trace a motion, the first on top of the others.
    """
    traces = tuple(
        Trace(
            motion.name,
            motion.trajectory.t,
            getattr(motion.trajectory, quantity),
            mark=motion.mark,
            colour=motion.colour,
        )
        for motion in reversed(motions)
    )
    return Chart(
        TIME_LABEL,
        label_of(quantity),
        traces,
        guides=(Guide(0.0, vertical=False),),
        strip=motions[0].separated if strip else None,
        x_axis=x_axis,
        x_range=(0.0, max(motion.t_end for motion in motions)),
    )


def difference_chart(quantity: str, motion: Motion, baseline: Motion, *, x_axis: bool) -> Chart:
    """How far a motion is from another over time.

    Parameters
    ----------
    quantity : str
        A column of the trajectory.
    motion, baseline : Motion
        The motion, and what is taken from it.
    x_axis : bool
        Whether to label the ticks of the time axis.

    Returns
    -------
    Chart
        Over the time that both have; between samples of the baseline by straight lines where
        their times differ.
    """
    t, there = motion.trajectory.t, baseline.trajectory.t
    t = t[t <= there[-1]]
    own = getattr(motion.trajectory, quantity)[: t.size]
    other = getattr(baseline.trajectory, quantity)
    same = np.array_equal(t, there[: t.size])
    values = own - (other[: t.size] if same else np.interp(t, there, other))
    note = f"{motion.name} − {baseline.name}" + ("" if same else ", interpolated")
    return Chart(
        TIME_LABEL,
        f"Δ{label_of(quantity)}",
        (Trace("", t, values, colour=motion.colour),),
        guides=(Guide(0.0, vertical=False),),
        note=note,
        x_axis=x_axis,
        x_range=(0.0, float(t[-1])),
    )


def second_half(t_end: float) -> tuple[float, float]:
    """The second half of a horizon: over it half peak-to-peak is taken."""
    return 0.5 * t_end, t_end


def _part(t: FloatArray, window: tuple[float, float]) -> slice:
    first, stop = np.searchsorted(t, window, side="left").tolist()
    return slice(first, stop + 1)


def _span(window: tuple[float, float]) -> str:
    return f"t {window[0]:.4g} to {window[1]:.4g} s"


def phase_chart(quantity: str, motions: Sequence[Motion], window: tuple[float, float]) -> Chart:
    """A displacement against its velocity.

    Parameters
    ----------
    quantity : str
        ``"x"`` or ``"y"``.
    motions : sequence of Motion
        At least one.
    window : tuple of float
        First and last time, s.

    Returns
    -------
    Chart
        A trace a motion, the first on top of the others; the line y = 0, where contact ends.
    """
    traces = []
    for motion in reversed(motions):
        part = _part(motion.trajectory.t, window)
        traces.append(
            Trace(
                motion.name,
                getattr(motion.trajectory, quantity)[part],
                getattr(motion.trajectory, f"v{quantity}")[part],
                ordered=False,
                mark=motion.mark,
                colour=motion.colour,
            )
        )
    guides = (Guide(0.0, "y = 0"),) if quantity == "y" else ()
    return Chart(
        label_of(quantity),
        label_of(f"v{quantity}"),
        tuple(traces),
        guides=guides,
        note=_span(window),
        tight=False,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Amplitudes over frequency.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Hz, ascending from 0.
    amplitude : ndarray, shape (n,)
        Of the sine of each frequency; at 0 the mean.
    fundamental : float
        Frequency of the greatest amplitude besides the mean, Hz; 0 if there is no vibration.
    resolution : float
        Distance of frequencies that can be told apart, Hz.
    """

    frequency: FloatArray
    amplitude: FloatArray
    fundamental: float
    resolution: float

    @property
    def period(self) -> float | None:
        """One over the fundamental frequency, s; None if there is no vibration."""
        return 1.0 / self.fundamental if self.fundamental > 0.0 else None


def spectrum(t: FloatArray, values: FloatArray) -> Spectrum:
    """The amplitude spectrum of a signal, seen through a Hann window.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Evenly spaced times, s; a last one that is nearer than the others does not count.
    values : ndarray, shape (n,)
        The signal.

    Returns
    -------
    Spectrum
        The mean is taken away before the window and put at frequency 0. The fundamental frequency
        is that of the parabola through the logarithms of the highest line and its neighbours.

    Raises
    ------
    InputError
        If there are fewer than 16 samples, or they are not evenly spaced.
    """
    if t.size > 1 and t[-1] - t[-2] < (1.0 - _UNEVEN) * (t[1] - t[0]):
        t, values = t[:-1], values[:-1]
    if t.size < _FEWEST:
        raise InputError(f"spectrum: {t.size} samples are too few, allowed are {_FEWEST} or more")
    step = float(t[-1] - t[0]) / (t.size - 1)
    if np.abs(np.diff(t) - step).max() > _UNEVEN * step:
        raise InputError("spectrum: the samples are not evenly spaced")
    mean = float(values.mean())
    # Periodic, so that its own lines fall on frequencies of the transform.
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(t.size) / t.size)
    lines = np.fft.rfft((values - mean) * window)
    amplitude: FloatArray = np.hypot(lines.real, lines.imag) * (2.0 / window.sum())
    amplitude[0] = abs(mean)
    resolution = 1.0 / (step * t.size)
    frequency = resolution * np.arange(lines.size, dtype=np.float64)
    return Spectrum(frequency, amplitude, _fundamental(amplitude, values) * resolution, resolution)


def _fundamental(amplitude: FloatArray, values: FloatArray) -> float:
    # In lines of the transform.
    highest = 1 + int(amplitude[1:].argmax())
    size = float(np.abs(values).max())
    if amplitude[highest] <= _NOISE * size:
        return 0.0
    if highest + 1 >= amplitude.size or highest == 1:
        return float(highest)
    below, top, above = np.log(np.maximum(amplitude[highest - 1 : highest + 2], 1e-300)).tolist()
    bend = below - 2.0 * top + above
    return highest + (0.5 * (below - above) / bend if bend < 0.0 else 0.0)


def spectrum_of(motion: Motion, window: tuple[float, float]) -> Spectrum:
    """The spectrum of y in a window of time, see `spectrum`."""
    part = _part(motion.trajectory.t, window)
    return spectrum(motion.trajectory.t[part], motion.trajectory.y[part])


def spectrum_chart(motions: Sequence[Motion], window: tuple[float, float]) -> Chart:
    """The spectra of y.

    Parameters
    ----------
    motions : sequence of Motion
        At least one.
    window : tuple of float
        First and last time, s.

    Returns
    -------
    Chart
        To some harmonics of the first motion, of which the first are marked.

    Raises
    ------
    InputError
        If a spectrum cannot be had, see `spectrum`.
    """
    spectra = [spectrum_of(motion, window) for motion in motions]
    first = spectra[0]
    traces = tuple(
        Trace(motion.name, found.frequency, found.amplitude, mark=motion.mark, colour=motion.colour)
        for motion, found in reversed(list(zip(motions, spectra, strict=True)))
    )
    base, note = first.fundamental, f"{_span(window)}, no vibration"
    guides: tuple[Guide, ...] = ()
    top = float(first.frequency[-1])
    if base > 0.0:
        top = min(top, _HARMONICS * base)
        guides = tuple(
            Guide(number * base, "f₁" if number == 1 else f"{number}f₁")
            for number in range(1, _MARKED + 1)
        )
        note = f"f₁ {base:.4g} Hz, period {1.0 / base:.4g} s, {_span(window)}"
    return Chart("f / Hz", "|y| / m", traces, guides=guides, note=note, x_range=(0.0, top))

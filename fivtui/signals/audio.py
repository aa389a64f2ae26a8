"""A run as a sound: a signal of its motion, with compressed time, as a WAV file."""

import math
import wave
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import check_output, check_suffix, describe_files, output_path, write_atomically
from fivtui.model import InputError, check_known
from fivtui.results import Result
from fivtui.transient import Trajectory, Transient

from .motion import check_window, is_rest, motion_at, period_of

# Columns of the trajectory: displacements, velocities and the contact force P.
SIGNALS: Final = ("x", "vx", "y", "vy", "P")
SUFFIXES: Final = (".wav",)
# Samples per second of sound, and limits of its duration, s.
_SAMPLE_RATE: Final = 44_100
_MAX_DURATION: Final = 600.0
_MIN_DURATION: Final = 0.01
# Default pitch, Hz.
_DEFAULT_PITCH: Final = 110.0
# Peak of the sound relative to the greatest sample of 16 bits, and that sample.
_PEAK_LEVEL: Final = 0.9
_MAX_SAMPLE: Final = 32_767
# Fade at both ends against clicks, s.
_FADE_DURATION: Final = 0.005


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SoundFile(Result):
    """Description of a sound file.

    Attributes
    ----------
    path : Path
        The file: WAV, mono, 16 bit, 44100 samples a second.
    signal : str
        The column of the trajectory that became the sound.
    factor : float
        Seconds of motion per second of sound, by which frequencies are multiplied.
    window : tuple of float
        Start and end of the motion in the sound, s.
    duration : float
        Duration of the sound, s.
    full_scale : float
        Greatest distance of the signal from its mean, in its unit, at the peak of the sound; 0 for
        silence.
    pitch : float or None
        Frequency of the late motion as heard, Hz; None without vibration.
    """

    path: Path
    signal: str
    factor: float
    window: tuple[float, float]
    duration: float
    full_scale: float
    pitch: float | None

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui sound --json`` prints."""
        return {**asdict(self), "path": str(self.path)}

    def _summary(self) -> list[tuple[str, str]]:
        pitch_text = "no vibration" if self.pitch is None else f"heard at {self.pitch:.4g} Hz"
        return [
            ("file", describe_files(self.path)),
            ("signal", f"{self.signal}, {self.window[0]:g} to {self.window[1]:g} s"),
            ("time", f"compressed {self.factor:g} times, {pitch_text}"),
            ("duration", f"{self.duration:.4g} s"),
        ]


def check_sound_path(path: Path) -> None:
    """Raise `InputError` if a sound cannot be written to this path; call it before computing."""
    check_suffix(path, "sound", SUFFIXES)
    check_output(path)


def sound(
    run: Transient,
    path: Path | str,
    *,
    signal: str = "vy",
    factor: float | None = None,
    window: tuple[float, float] | None = None,
    force: bool = False,
) -> SoundFile:
    """Write a run as a sound with compressed time.

    Parameters
    ----------
    run : Transient
        The run, computed with ``samples="dense"`` or with sample times that resolve the motion.
    path : Path or str
        The file, with the suffix ``.wav``.
    signal : str
        The signal: ``x``, ``vx``, ``y``, ``vy`` or ``P``. Its mean is removed and its peak scaled.
    factor : float, optional
        Seconds of motion per second of sound; below 1, time is stretched. By default the motion
        late in the run has 110 Hz in the sound.
    window : tuple of float, optional
        Start and end of the motion in the sound, s; by default the whole run.
    force : bool
        Whether an existing file may be replaced.

    Returns
    -------
    SoundFile
        The file, with the factor, the duration and the frequency in the sound.

    Raises
    ------
    InputError
        If an input is wrong, the sound would last less than 0.01 s or more than 600 s, or the file
        cannot be written.

    Examples
    --------
    >>> from fivtui import simulate, sound
    >>> heard = sound(simulate(samples="dense"), "run.wav", factor=200)
    >>> f"{heard.duration:.2f} s at {heard.pitch:.0f} Hz"
    '0.50 s at 151 Hz'
    """
    path = output_path(path, force=force)
    check_sound_path(path)
    check_known("signal", signal, SIGNALS)
    start, end = (0.0, run.t_end) if window is None else check_window(run, window)
    period = period_of(run)
    if factor is None:
        factor = float(f"{_DEFAULT_PITCH * period:.3g}") if period else 1.0
    elif not (math.isfinite(factor) and factor > 0.0):
        raise InputError(f"factor = {factor:g}: must be above 0")
    duration = (end - start) / factor
    if not _MIN_DURATION <= duration <= _MAX_DURATION:
        raise InputError(
            f"factor = {factor:g}: the sound of {end - start:g} s would last {duration:.3g} s; "
            f"must be {_MIN_DURATION:g} to {_MAX_DURATION:g} s"
        )
    times = np.minimum(
        start + factor / _SAMPLE_RATE * np.arange(round(duration * _SAMPLE_RATE)), end
    )
    samples, full_scale = _normalise(motion_at(run, times), signal)

    def write(file: BinaryIO) -> None:
        with wave.open(file, "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(_SAMPLE_RATE)
            out.writeframes(np.round(_PEAK_LEVEL * _MAX_SAMPLE * samples).astype("<i2").tobytes())

    write_atomically(path, write)
    pitch = factor / period if period else None
    return SoundFile(Path(path), signal, factor, (start, end), duration, full_scale, pitch)


def _normalise(motion: Trajectory, signal: str) -> tuple[NDArray[np.float64], float]:
    # The signal without its mean, scaled to −1 to 1 and faded at both ends; and the scale.
    values: NDArray[np.float64] = getattr(motion, signal)
    values = values - values.mean()
    scale = float(np.abs(values).max())
    if scale == 0.0 or is_rest(motion):
        return np.zeros_like(values), 0.0
    offsets = np.arange(values.size) + 0.5
    fade = np.minimum(np.minimum(offsets, offsets[::-1]) / (_FADE_DURATION * _SAMPLE_RATE), 1.0)
    return values / scale * fade, scale

"""A run as a sound."""

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

SIGNALS: Final = ("x", "vx", "y", "vy", "P")
SUFFIXES: Final = (".wav",)
_RATE: Final = 44_100
_LONGEST: Final = 600.0
_SHORTEST: Final = 0.01
# Default pitch, Hz.
_PITCH: Final = 110.0
# Peak level relative to full scale.
_LEVEL: Final = 0.9
_FULL: Final = 32_767
# Fade at both ends against clicks, s.
_FADE: Final = 0.005


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SoundFile(Result):
    """What was written as a sound.

    Attributes
    ----------
    path : Path
        The file: WAV, mono, 16 bit, 44100 samples a second.
    signal : str
        The column of the trajectory that is heard.
    factor : float
        Seconds of the motion in a second of the sound: frequencies are heard multiplied by it.
    window : tuple of float
        Start and end of what is heard, s.
    duration : float
        Of the sound, s.
    full_scale : float
        Value of the signal, less its mean, that is full scale; 0 for silence.
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
        heard = "no vibration" if self.pitch is None else f"heard at {self.pitch:.4g} Hz"
        return [
            ("file", describe_files(self.path)),
            ("signal", f"{self.signal}, {self.window[0]:g} to {self.window[1]:g} s"),
            ("time", f"compressed {self.factor:g} times, {heard}"),
            ("duration", f"{self.duration:.4g} s"),
        ]


def check_sound_path(path: Path) -> None:
    """Raise `InputError` if a sound cannot be written to this path; checks before computing."""
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
    """Write a run as a sound, its time compressed.

    Parameters
    ----------
    run : Transient
        Computed with ``samples="dense"``, or with sample times close enough for its motion.
    path : Path or str
        The file, with the suffix ``.wav``.
    signal : str
        What is heard: ``x``, ``vx``, ``y``, ``vy`` or ``P``, less its mean and normalised.
    factor : float, optional
        Seconds of the motion in a second of the sound; below 1 time is stretched. By default the
        late motion is heard at 110 Hz.
    window : tuple of float, optional
        Start and end of what is heard, s; the whole run if not given.
    force : bool
        Whether an existing file may be replaced.

    Returns
    -------
    SoundFile
        The factor, the duration and the frequency heard.

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
        factor = float(f"{_PITCH * period:.3g}") if period else 1.0
    elif not (math.isfinite(factor) and factor > 0.0):
        raise InputError(f"factor = {factor:g}: must be above 0")
    duration = (end - start) / factor
    if not _SHORTEST <= duration <= _LONGEST:
        raise InputError(
            f"factor = {factor:g}: the sound of {end - start:g} s would last {duration:.3g} s; "
            f"must be {_SHORTEST:g} to {_LONGEST:g} s"
        )
    times = np.minimum(start + factor / _RATE * np.arange(round(duration * _RATE)), end)
    heard, full_scale = _normalised(motion_at(run, times), signal)

    def write(file: BinaryIO) -> None:
        with wave.open(file, "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(_RATE)
            out.writeframes(np.round(_LEVEL * _FULL * heard).astype("<i2").tobytes())

    write_atomically(path, write)
    pitch = factor / period if period else None
    return SoundFile(Path(path), signal, factor, (start, end), duration, full_scale, pitch)


def _normalised(motion: Trajectory, signal: str) -> tuple[NDArray[np.float64], float]:
    # The signal without its mean, scaled to −1 to 1 and faded at both ends, and the scale.
    values: NDArray[np.float64] = getattr(motion, signal)
    values = values - values.mean()
    greatest = float(np.abs(values).max())
    if greatest == 0.0 or is_rest(motion):
        return np.zeros_like(values), 0.0
    ends = np.arange(values.size) + 0.5
    fade = np.minimum(np.minimum(ends, ends[::-1]) / (_FADE * _RATE), 1.0)
    return values / greatest * fade, greatest

"""Runs as sound files."""

import json
import math
import wave
from pathlib import Path

import numpy as np
import pytest

from fivtui.cli import run as command
from fivtui.model import InputError, Parameters
from fivtui.signals.audio import sound
from fivtui.simulation import simulate

RUN = simulate(t_end=100.0, samples="dense")


def read_samples(path: Path) -> tuple[np.ndarray, int]:
    with wave.open(str(path)) as file:
        assert (file.getnchannels(), file.getsampwidth()) == (1, 2)
        return np.frombuffer(file.readframes(file.getnframes()), "<i2"), file.getframerate()


def test_the_sound_is_the_signal_with_its_time_compressed(tmp_path: Path) -> None:
    audio = sound(RUN, tmp_path / "a.wav", signal="y", factor=100.0, window=(50.0, 100.0))
    values, sample_rate = read_samples(audio.path)
    assert values.size == round(0.5 * sample_rate)
    assert audio.duration == 0.5
    middle = slice(values.size // 4, 3 * values.size // 4)
    assert RUN.solution is not None
    y = RUN.solution(50.0 + 100.0 / sample_rate * np.arange(values.size)).y
    signal = y - y.mean()
    amplitude = np.abs(signal).max()
    # The peak has 0.9 of the full scale of 16 bits; fades at the ends are outside the middle.
    expected = 0.9 * 32_767 * signal / amplitude
    assert np.abs(values[middle] - expected[middle]).max() < 1.0
    # In m: the signal at the peak of the sound.
    assert audio.full_scale == pytest.approx(amplitude)
    # The sound begins and ends in silence.
    for value in (int(values[0]), int(values[-1])):
        assert abs(value) < 100


def test_by_default_the_late_motion_sounds_at_110_hz(tmp_path: Path) -> None:
    audio = sound(RUN, tmp_path / "a.wav")
    assert audio.pitch == pytest.approx(110.0, rel=0.01)
    values, sample_rate = read_samples(audio.path)
    late = values[values.size // 2 :].astype(float)
    spectrum = np.abs(np.fft.rfft(late * np.hanning(late.size)))
    resolution = sample_rate / late.size
    assert spectrum.argmax() * resolution == pytest.approx(110.0, abs=resolution)


def test_rest_is_silence(tmp_path: Path) -> None:
    audio = sound(simulate(Parameters(mu=0.0), t_end=2.0, samples=3), tmp_path / "a.wav")
    assert audio.full_scale == 0.0
    assert audio.pitch is None
    assert not read_samples(audio.path)[0].any()


@pytest.mark.parametrize(
    ("options", "refusal"),
    [
        ({"signal": "t"}, "signal"),
        ({"factor": 0.0}, "must be above 0"),
        ({"factor": math.nan}, "must be above 0"),
        # Sounds of 1000 s and 0.001 s.
        ({"factor": 0.1}, "must be 0.01 to 600 s"),
        ({"factor": 1e5}, "must be 0.01 to 600 s"),
        ({"window": (5.0, 101.0)}, "from 0 to 100 s"),
    ],
)
def test_unsuitable_sound_requests_are_refused(
    options: dict[str, float], refusal: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=refusal):
        sound(RUN, tmp_path / "a.wav", **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_a_sound_file_is_overwritten_only_by_request(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        sound(RUN, path)
    with pytest.raises(InputError, match="suffix of a sound file"):
        sound(RUN, tmp_path / "a.mp3")
    assert path.read_text() == "mine"


def test_the_command_reports_factor_and_window(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    # The signal P is the contact force.
    arguments = ["sound", "--t-end", "20", "--factor", "50", "--signal", "P", "--out", "a.wav"]
    assert command([*arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["factor"] == 50.0
    assert report["window"] == [0.0, 20.0]
    assert report["duration"] == pytest.approx(0.4)
    assert read_samples(tmp_path / "a.wav")[0].size == round(0.4 * 44_100)
    # A run by rk4 has no dense solution: the command interpolates its samples.
    assert command([*arguments, "--force", "--method", "rk4", "--step", "0.01"]) == 0
    assert "compressed 50 times" in capsys.readouterr().out
    for invalid_option in (
        ["--window", "3"],
        ["--window", "a:b"],
        ["--factor", "x"],
        ["--signal", "z"],
    ):
        assert command([*arguments, "--force", *invalid_option]) == 2

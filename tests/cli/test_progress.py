"""Commands report their progress from 0 to 1."""

from pathlib import Path

import pytest

from fivtui.cli import run
from fivtui.console import printing

COMMANDS = {
    "simulate": ["simulate", "--t-end", "5"],
    "run": ["run", "own.toml"],
    "compare": ["compare", "own.toml", "--out", "out"],
}


class RecordingBar(printing.ProgressBar):
    """Stands in for the progress bar and records what it receives."""

    def __init__(self, label: str) -> None:
        super().__init__(label)
        self.fractions: list[float] = []
        bars.append(self)

    def __call__(self, fraction: float) -> bool:
        self.fractions.append(fraction)
        return True


bars: list[RecordingBar] = []


@pytest.mark.parametrize("name", COMMANDS)
def test_the_progress_of_a_command_rises_from_zero_to_one(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bars.clear()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fivtui.console.ProgressBar", RecordingBar)
    Path("own.toml").write_text("fivtui_scene = 1\nt_end = 5.0\n[parameters]\nF = 60.0\n")
    assert run(COMMANDS[name]) == 0, capsys.readouterr().err
    (bar,) = bars
    assert len(bar.fractions) >= 2
    assert bar.fractions == sorted(bar.fractions)
    assert 0.0 <= bar.fractions[0] < 0.5
    assert bar.fractions[-1] == pytest.approx(1.0)

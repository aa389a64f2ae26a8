"""Printed text, files, results, tabs, FMUs and bits agree with their recordings."""

import sys

import pytest

from tests.net.parts import PARTS
from tests.net.text import RECORDED, differences

# Parts compared by default; the others are marked `whole`.
QUICK = (
    "commands-errors",
    "commands-over-time",
    "commands-program",
    "commands-simulate",
    "commands-sweep",
    "stored-files",
    "fmus",
    "bits",
    "bits-interpreted",
)
MAX_MESSAGE_LINES = 60


def recording_mismatch(name: str, text: str) -> str:
    """Differences from a recording, and how to record it anew; empty if there are none."""
    recorded = (RECORDED / f"{name}.txt").read_text(encoding="utf-8")
    lines = differences(recorded, text)
    if not lines:
        return ""
    if len(lines) > MAX_MESSAGE_LINES:
        lines = [*lines[:MAX_MESSAGE_LINES], f"... {len(lines) - MAX_MESSAGE_LINES} further lines"]
    advice = f"if this is intended: python -m tests.net.record {name}, and look at git diff"
    return "\n".join([f"{name} (- recorded, + now)", *lines, advice])


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.whole) for name in PARTS],
)
def test_output_agrees_with_its_recording(name: str) -> None:
    if name == "bits-interpreted" and sys.version_info >= (3, 12):
        pytest.skip("sum() of floats is more accurate from Python 3.12 on, so bits differ")
    message = recording_mismatch(name, PARTS[name]())
    if message:
        pytest.fail(message, pytrace=False)


def test_every_part_has_one_recording_and_all_are_small() -> None:
    assert {path.stem for path in RECORDED.iterdir()} == set(PARTS)
    assert sum(path.stat().st_size for path in RECORDED.iterdir()) < 3_000_000

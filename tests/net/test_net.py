"""Text, files, results, tabs, FMUs and bits are as recorded."""

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
)
LONGEST_MESSAGE = 60


def unlike_recording(name: str, text: str) -> str:
    """Differences from a recording, and how to record it anew; empty if there are none."""
    recorded = (RECORDED / f"{name}.txt").read_text(encoding="utf-8")
    lines = differences(recorded, text)
    if not lines:
        return ""
    if len(lines) > LONGEST_MESSAGE:
        lines = [*lines[:LONGEST_MESSAGE], f"... {len(lines) - LONGEST_MESSAGE} further lines"]
    advice = f"if this is intended: python -m tests.net.record {name}, and look at git diff"
    return "\n".join([f"{name} (- recorded, + now)", *lines, advice])


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.whole) for name in PARTS],
)
def test_what_a_user_gets_is_what_was_recorded(name: str) -> None:
    message = unlike_recording(name, PARTS[name]())
    if message:
        pytest.fail(message, pytrace=False)


def test_recordings_are_those_of_the_parts_and_small() -> None:
    assert {path.stem for path in RECORDED.iterdir()} == set(PARTS)
    assert sum(path.stat().st_size for path in RECORDED.iterdir()) < 3_000_000

"""Recordings agree if their numbers are within a tolerance and their words are equal."""

import pytest

from tests.net.text import (
    column_line,
    data_lines,
    differences,
    mask_varying,
    same_line,
    sections_of,
)


@pytest.mark.parametrize(
    ("recorded", "fresh"),
    [
        ("peak 2.14453752247 m", "peak 2.14453752248 m"),
        ("y [2]: 1.0 1e-17", "y [2]: 1.0 -3e-16"),
        # Both are below ABSOLUTE_TOLERANCE.
        ("difference   6.1e-12 m", "difference   5.97e-13 m"),
        ("x 1.00000000000000  m", "x 1.0000000000000001 m"),
    ],
)
def test_lines_with_numbers_within_the_tolerance_agree(recorded: str, fresh: str) -> None:
    assert same_line(recorded, fresh)


@pytest.mark.parametrize(
    ("recorded", "fresh"),
    [
        ("peak 2.1445375 m", "peak 2.1445376 m"),
        ("peak 2.1445375 m", "peak 2.1445375 mm"),
        ("peak 2.1445375 m", "peak  2.1445375 m"),
        ("k1 3", "k2 3"),
        ("y [2]: 1.0 2.0", "y [2]: 1.0"),
        ("tiny 1e-6 m", "tiny 1.00001e-6 m"),
        ("sum -1.0", "sum 1.0"),
    ],
)
def test_lines_with_unequal_numbers_words_or_blanks_differ(recorded: str, fresh: str) -> None:
    assert not same_line(recorded, fresh)


def test_a_difference_names_the_command_and_its_lines() -> None:
    recorded = "$ fivtui a\nexit 0\nx 1\n$ fivtui b\nexit 0\n$ fivtui b\nexit 2\n"
    assert not differences(recorded, recorded)
    assert differences(recorded, recorded.replace("x 1", "x 2")) == [
        "$ fivtui a",
        "  - x 1",
        "  + x 2",
    ]
    assert list(sections_of(recorded)) == ["$ fivtui a", "$ fivtui b", "$ fivtui b (again)"]
    short = "$ fivtui a\nexit 0\nx 1\n"
    assert differences(recorded, short)[:2] == ["$ fivtui b", "    no longer there"]
    assert differences(short, recorded)[-2:] == ["$ fivtui b (again)", "    not recorded"]
    assert differences(short, short + "y\n")[1:] == ["  - (no line)", "  + y"]


def test_run_dependent_text_is_masked_and_long_columns_are_shortened() -> None:
    text = mask_varying("CPU time    0.0003 s\nat 12:00:01 on 2026-11-23 in /tmp/a.csv  ")
    assert text == "CPU time <time>\nat <time> on <date> in /tmp/a.csv"
    lines = list(
        data_lines({"stats": {"cpu_s": 0.1, "steps": 3}, "a": [1.0, 2.0], "b": [{"c": 1}]})
    )
    assert lines == [
        "stats.cpu_s: <varies>", "stats.steps: 3", "a [2]: 1.0 2.0", "b: 1 items", "b[0].c: 1",
    ]  # fmt: skip
    long_column = column_line("t", [float(n) for n in range(100)])
    assert long_column.startswith("t [100]: 0.0 4.0 ")
    # Sizes are absolute values.
    assert long_column.endswith(" 99.0 sum of sizes 4950.0")

"""Colours of charts: told apart with every deficiency and in 16 colours, visible on all themes."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from rich.color import Color, ColorSystem
from textual.theme import BUILTIN_THEMES, Theme

import fivtui
from fivtui.charts import INKS, Trace, figure_colour, series_role
from fivtui.charts.chart import trace_mark
from fivtui.charts.colours import SERIES_COUNT, Ink
from fivtui.film import Timing, belt_chart, layout_of
from fivtui.simulation import simulate
from fivtui.tui.chart import with_chart_colours
from fivtui.tui.session import base_scene
from fivtui.tui.session.runs import MARKERS, Run
from tests.support.colour import VISIONS, contrast, difference, seen_lab

MEANINGS = ("danger", "warning", "safe")
SERIES = tuple(map(series_role, range(SERIES_COUNT)))
SHADES = pytest.mark.parametrize("background", Ink._fields)


def least_difference(pairs: list[tuple[str, str]], background: str) -> float:
    return min(
        difference(*(seen_lab(getattr(INKS[role], background), vision) for role in pair))
        for pair in pairs
        for vision in VISIONS
    )


def test_the_difference_of_colours_is_that_of_published_pairs() -> None:
    # G. Sharma et al. (2005), pairs 1, 7 and 17.
    for first, second, expected in (
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ):
        assert difference(np.array(first), np.array(second)) == pytest.approx(expected, abs=1e-4)
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)


@SHADES
def test_colours_differ_with_every_deficiency(background: str) -> None:
    assert least_difference(list(combinations(MEANINGS, 2)), background) > 11.0
    assert least_difference(list(combinations(SERIES, 2)), background) > 8.5
    assert least_difference([("danger", role) for role in SERIES], background) > 8.5
    # The first three series differ most.
    assert least_difference(list(combinations(SERIES[:3], 2)), background) > 13.0


@SHADES
def test_meanings_stay_distinct_in_16_colours_and_series_have_marks(background: str) -> None:
    numbers = {
        role: Color.parse(getattr(ink, background)).downgrade(ColorSystem.STANDARD).number
        for role, ink in INKS.items()
    }
    assert len({numbers[role] for role in MEANINGS}) == len(MEANINGS)
    assert all(numbers["danger"] != numbers[role] for role in SERIES)
    marks = {
        trace_mark(Trace("", np.zeros(1), np.zeros(1)), index) for index in range(SERIES_COUNT)
    }
    assert len(marks) == SERIES_COUNT
    runs = [Run(number, base_scene()) for number in range(1, SERIES_COUNT * len(MARKERS) + 1)]
    assert len({run.look for run in runs}) == len(runs)


def test_lines_contrast_with_the_background_of_every_theme() -> None:
    # 3:1 is the limit of WCAG 2 for graphics.
    assert all(contrast(figure_colour(role), "#ffffff") >= 3.0 for role in INKS)
    for builtin in BUILTIN_THEMES.values():
        theme = with_chart_colours(builtin)
        assert theme.error == theme.variables["danger"] == theme.variables["text-error"]
        if not theme.ansi:
            background = theme.to_color_system().generate()["background"]
            low = [r for r in INKS if contrast(theme.variables[r], background) < 3.0]
            assert not low, (theme.name, low)


def test_a_theme_of_the_user_keeps_its_own_meanings() -> None:
    theme = with_chart_colours(Theme("mine", "#112233", error="#aa0000"), chosen=("error",))
    assert theme.error == theme.variables["danger"] == theme.variables["text-error"] == "#aa0000"
    assert theme.success == INKS["safe"].dark


def test_a_colour_of_less_strength_is_mixed_with_white() -> None:
    assert figure_colour("danger", 0.0) == "#ffffff"
    assert figure_colour("danger") == INKS["danger"].light


def test_colours_are_written_in_one_table() -> None:
    folder = Path(fivtui.__file__).parent
    files = [path for path in folder.rglob("*") if path.suffix in {".py", ".tcss"}]
    assert len(files) > 200
    written = {
        path.relative_to(folder).as_posix()
        for path in files
        if re.search(r"[\"' ]#[0-9a-fA-F]{6}\b", path.read_text(encoding="utf-8"))
    }
    # The message about a wrong colour in the configuration has an example.
    assert written == {"charts/colours.py", "tui/persistence/config.py"}


def test_danger_has_a_colour_that_nothing_on_the_belt_shares() -> None:
    run = simulate(t_end=4.0, samples=101)
    assert run.trajectory is not None
    layout = layout_of(run.trajectory)
    timing = Timing(0.0, run.t_end, 1.0)
    chart = belt_chart(run, layout, timing, 0.0, 2.0)
    colours = {trace.name: trace.colour for trace in chart.traces}
    assert (colours["belt"], colours["friction"]) == ("belt", "friction")
    assert len({INKS[colour] for colour in colours.values()}) == len(colours)
    assert INKS["danger"] not in {INKS[colour] for colour in colours.values()}

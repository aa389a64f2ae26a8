"""Levels of maps: round bounds, plateaus with their values, no division of nearly equal values."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from fivtui import Parameters, stability_map
from fivtui.charts import figure_colour
from fivtui.charts.chart import View
from fivtui.charts.shades import _GRADES, grade, grade_values, hide_unused, scale_swatches
from fivtui.maps.charts import _STABLE_SHADES, _UNSTABLE_SHADES, map_chart
from fivtui.tui.chart.picture import draw
from tests.support.colour import VISIONS, difference, seen_lab

CONTRAST = 1e-3


def is_round(number: float) -> bool:
    """Whether a number is a multiple of 1, 2 or 5 times a power of ten, of one or two figures."""
    return number == pytest.approx(float(f"{number:.2g}"))


def scale_of(values: list[float]) -> str:
    grading, shades = grade_values(np.array(values))
    entries = scale_swatches(hide_unused(grading.levels, shades))
    return " ".join(f"{swatch} {shade.text}" for swatch, shade in entries)


@given(
    st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=60),
    st.floats(1e-3, 1e3),
)
@example([0.0, 5e-324], 1.0)
def test_levels_ascend_and_contain_their_values(values: list[float], factor: float) -> None:
    array = factor * np.array(values)
    grading = grade(array, 6)
    assert 1 <= len(grading.bands) <= 6
    assert set(grading.levels.tolist()) == set(range(len(grading.bands)))
    order = np.argsort(array)
    assert np.all(np.diff(grading.levels[order]) >= 0)
    largest = np.abs(array).max()
    for value, level in zip(array, grading.levels, strict=True):
        band = grading.bands[level]
        # A bound may be shifted by at most 1.5 times the smallest displayed difference.
        slack = 1.5 * CONTRAST * abs(value) * 1.01 + 1e-8 * largest
        assert band.lower is None or value >= band.lower - slack
        assert band.upper is None or value <= band.upper + slack
        if band.plateau is not None:
            assert abs(value - band.plateau) <= slack


def test_bounds_are_round_and_evenly_or_logarithmically_spaced() -> None:
    narrow = grade(np.linspace(0.11, 0.33, 200), 6).bounds
    assert narrow == pytest.approx([0.15, 0.2, 0.25, 0.3])
    assert grade(np.linspace(-3.0, 7.0, 200), 6).bounds == pytest.approx([-2, 0, 2, 4, 6])
    assert grade(np.geomspace(0.015, 3.0, 200), 6).bounds == pytest.approx([0.1, 1.0])
    assert all(map(is_round, grade(np.linspace(0.2799, 1.183, 50), 6).bounds))


def test_nearly_equal_values_share_a_level_beside_a_round_number() -> None:
    # 0.3 would be a bound; 41 values around it differ by less than a thousandth.
    group = np.linspace(0.29995, 0.30005, 41)
    grading = grade(np.concatenate([group, np.linspace(0.1, 0.9, 20)]), 6)
    assert len(set(grading.levels[:41].tolist())) == 1
    assert grading.bands[grading.levels[0]].plateau == pytest.approx(0.3, rel=CONTRAST)
    # A few such values are no plateau, and not divided either.
    pair = grade(np.array([0.2999, 0.3001, *np.linspace(0.1, 0.9, 20)]), 6)
    assert pair.levels[0] == pair.levels[1]


def test_scales_name_plateaus_by_value_and_other_levels_by_bounds() -> None:
    assert scale_of([0.278] * 4) == "▒ 0.278"
    assert scale_of([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1e-13]) == "blank 0 █ 1"
    assert scale_of([0.278] * 9 + [0.31, 0.45, 0.62]) == "blank 0.278 ░ ≤0.4 ▒ ≤0.5 █ >0.6"
    assert scale_of([0.31, 0.3106]) == "▒ ≤0.311"
    assert scale_of([math.nan, 1200.0, 5600.0]) == "blank ≤2000 █ >5000 ? none"
    assert scale_of([math.nan]) == "? none"


def test_a_plateau_is_labelled_in_its_middle_in_terminal_and_figure() -> None:
    result = stability_map(
        Parameters(), {"mu": np.linspace(0.0, 1.5, 31), "F": np.linspace(10.0, 110.0, 21)}
    )
    chart = map_chart(result)
    assert chart.backdrop is not None
    # Without coupling by friction all modes decay at c/(2m) = 0.032 1/s.
    ((x, y, text),) = chart.backdrop.labels
    assert text == "-0.032"
    x_index, y_index = np.searchsorted(result.axes[0], x), np.searchsorted(result.axes[1], y)
    assert result.values[x_index, y_index] == pytest.approx(-0.032, rel=1e-3)
    assert " -0.032 " in draw(chart, View(), 80, 24).text()
    (axes, _) = result.figure().axes
    assert text in {label.get_text() for label in axes.texts}


def test_a_map_of_a_single_row_is_drawn_as_points() -> None:
    result = stability_map(None, {"F": [60.0, 80.0, 120.0], "k_nl": [100.0]}, "critical-mu")
    axes, bar = result.figure().axes
    (points,) = axes.collections
    assert np.shape(points.get_offsets()) == (3, 2)
    assert [label.get_text() for label in bar.get_yticklabels()] == ["≤0.4", "≤0.5", ">0.7"]


def test_growth_that_is_zero_but_for_rounding_has_one_level() -> None:
    # Without damping no mode decays: below the critical friction all growth rates are rounding.
    undamped = Parameters(c1=0.0, c2=0.0)
    result = stability_map(
        undamped, {"mu": np.linspace(0.0, 1.0, 11), "F": np.linspace(40.0, 80.0, 5)}
    )
    backdrop = map_chart(result).backdrop
    assert backdrop is not None
    rounding = np.abs(result.values) < 1e-6
    assert 0 < np.count_nonzero(rounding) < rounding.size
    (level,) = set(backdrop.levels[rounding].tolist())
    assert (backdrop.shades[level].character, backdrop.shades[level].text) == ("=", "0")
    assert level not in backdrop.levels[~rounding]


def test_shades_of_figures_differ_with_every_deficiency() -> None:
    pairs = [
        *pairwise(_GRADES),
        *pairwise(_UNSTABLE_SHADES),
        *((decay, growth) for decay in _STABLE_SHADES for growth in _UNSTABLE_SHADES),
    ]
    for first, second in pairs:
        for vision in VISIONS:
            seen = (seen_lab(shade.figure_colour, vision) for shade in (first, second))
            assert difference(*seen) > 5.0
    assert figure_colour("safe", 0.3) == _STABLE_SHADES[0].figure_colour

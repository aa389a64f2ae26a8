"""Maps of safe friction in the laboratory: their shades and scale, and one start of the app."""

from dataclasses import replace

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui import Parameters, safety_map
from fivtui.charts import NO_VALUE, grade_values, scale_swatches, screen_colours
from fivtui.charts.chart import Cursors, View
from fivtui.maps import StabilityMap
from fivtui.maps.charts import grade_regions, map_chart, shown_offsets
from fivtui.maps.searched_points import SearchedPoint
from fivtui.tui.chart import ShadeScale
from fivtui.tui.chart.picture import draw
from fivtui.tui.tabs.studies.map import map_ranges
from tests.support.laboratory import (
    chart_of,
    clear_notices,
    click_view,
    lab_of,
    type_into,
    until_shown,
)


@pytest.fixture(scope="module")
def regions() -> StabilityMap:
    axis_values = {"F": np.array([120.0, 110.0, 100.0]), "mu": np.linspace(0.1, 0.9, 9)}
    return safety_map(None, axis_values, "coexistence")


def scale_of(result: StabilityMap) -> str:
    backdrop = map_chart(result).backdrop
    assert backdrop is not None
    return " ".join(f"{swatch} {shade.text}" for swatch, shade in scale_swatches(backdrop.shades))


def test_a_map_of_coexistence_has_three_kinds_of_shades(regions: StabilityMap) -> None:
    chart = map_chart(regions, Parameters(F=110.0))
    scale = scale_of(regions)
    assert scale.startswith("· safe ▓ <")
    assert scale.endswith(" m █ squeals")
    backdrop = chart.backdrop
    assert backdrop is not None
    assert np.all(np.diff(backdrop.x) > 0.0)
    # Along μ at the smallest preload: safe, unsafe after a knock, squealing.
    characters = [backdrop.shades[level][0] for level in backdrop.levels[0]]
    assert characters[0] == "·"
    assert set("░▒▓") & set(characters[1:-1])
    assert characters[-1] == "█"
    heading = draw(chart, View(cursors=Cursors((100.0, 0.9))), 80, 24).text()
    assert "escapes from 0" in heading


def test_the_least_displacement_that_leads_to_squeal_is_zero_where_the_slider_squeals(
    regions: StabilityMap,
) -> None:
    offsets = shown_offsets(regions)
    assert np.isnan(offsets[regions.regions == 0.0]).all()
    assert np.all(offsets[regions.regions == 2.0] == 0.0)
    knock_offsets = offsets[regions.regions == 1.0]
    assert np.all((knock_offsets > 0.0) & np.isfinite(knock_offsets))


@pytest.fixture(scope="module")
def nearly_constant_map() -> StabilityMap:
    return safety_map(None, {"F": [80.0, 120.0], "k_nl": [95.0, 105.0]})


def test_negligible_differences_have_one_shade(nearly_constant_map: StabilityMap) -> None:
    # Safe μ is that of the fold, at which limit cycles appear; it differs by 2e-4 of its value.
    assert 0.0 < np.ptp(nearly_constant_map.safe_mu) < 1e-3 * nearly_constant_map.safe_mu.max()
    chart = map_chart(nearly_constant_map, None)
    assert chart.note == "safe μ"
    assert chart.backdrop is not None
    assert np.unique(chart.backdrop.levels).size == 1
    # The plateau is labelled with its value, in the scale and in its middle.
    assert scale_of(nearly_constant_map).split() == ["▒", "0.278"]
    axes, bar = nearly_constant_map.figure().axes
    assert list(axes.texts) == []
    assert [label.get_text() for label in bar.get_yticklabels()] == ["0.278"]
    # Larger differences have shades of their own, and a plateau has one shade.
    plateau = np.array([[0.2778, 0.27785, 0.2779, 0.4], [0.2778, 0.9, 0.9001, np.nan]])
    grading, shades = grade_values(plateau)
    levels = grading.levels
    assert len({*levels[0, :3].tolist(), levels[1, 0]}) == 1
    (plateau_level, _, _, middle_level), (_, *high_levels, missing_level) = levels.tolist()
    assert plateau_level < middle_level < min(high_levels) == max(high_levels)
    assert shades[missing_level] == NO_VALUE
    # Displacements that lead to squeal, m, share a level if they differ by less than 4 %, twice
    # their accuracy. The greatest have the lightest shade.
    escape = np.array([[1.0, 1.01, 1.02, 1.03, 3.0]])
    regions, shades = grade_regions(np.ones((1, 5)), escape)
    *near, far = (shades[level] for level in regions.levels[0])
    assert [shade.text for shade in (near[0], far)] == ["1 m", "≥2 m"]
    assert len(set(near)) == 1
    assert (near[0].character, far.character) == ("▓", "░")


def test_a_map_distinguishes_missing_from_unknown_safe_friction(
    nearly_constant_map: StabilityMap,
) -> None:
    safe_mu = nearly_constant_map.safe_mu.copy()
    critical_mu = nearly_constant_map.critical_mu.copy()
    # Without safe μ and critical μ there is none; without safe μ alone it is not known.
    safe_mu[0], critical_mu[0, 0] = np.nan, np.nan
    quantities = {"safe_mu": safe_mu, "critical_mu": critical_mu}
    partial_map = replace(nearly_constant_map, quantities=quantities, searched=())
    assert partial_map.unknown.tolist() == [[False, True], [False, False]]
    assert scale_of(partial_map).endswith("? none × not known")
    for position, reading in (((80.0, 95.0), "none"), ((80.0, 105.0), "not known")):
        view = View(cursors=Cursors(position))
        assert f"safe μ {reading}" in draw(map_chart(partial_map, None), view, 80, 24).text()
    (legend,) = partial_map.figure().legends
    assert {"none", "not known"} <= {text.get_text() for text in legend.get_texts()}
    # Without critical μ, a search that confirms only a limited μ also makes it unknown.
    limiting_search = SearchedPoint(indices=(0, 0), confirmed_to=0.2)
    contradicted = replace(partial_map, searched=(limiting_search,))
    assert contradicted.unknown.tolist() == [[True, True], [False, False]]
    with_critical_mu = replace(
        partial_map, quantities=quantities | {"critical_mu": nearly_constant_map.critical_mu}
    )
    assert "none" not in scale_of(with_critical_mu)
    assert scale_of(with_critical_mu).endswith("× not known")
    region = {"region": np.where(np.isnan(safe_mu), np.nan, 1.0)}
    regions = replace(
        with_critical_mu, value="coexistence", quantities={**with_critical_mu.quantities, **region}
    )
    assert "not known" in scale_of(regions)
    # `excess`, the distance from the stability boundary, is NaN without a verdict.
    no_values = np.full((2, 2), np.nan)
    without_verdict = replace(
        regions, excess=no_values, quantities={**regions.quantities, "region": no_values}
    )
    assert scale_of(without_verdict) == "? no verdict"


async def test_safe_friction_is_mapped_by_two_keys_and_refused_over_friction(
    pilot: Pilot[None],
) -> None:
    await pilot.press("alt+5")
    await until_shown(pilot, "F10 maps 600 points")
    range_input = pilot.app.screen.query_one("#safe-mu-input", Input)
    # The proposed ranges can be mapped. Values that do not depend on μ have separate ranges.
    default_ranges = range_input.value
    assert map_ranges(default_ranges, "safe-mu")
    range_input.value = "F=60:120:4 mu=0.1:0.2:2"
    range_input.focus()
    await pilot.press("enter")
    await until_shown(pilot, "must be over two other parameters")
    range_input.value = "F=60:120:4 k_nl=90:110:2"
    await pilot.press("enter")
    await until_shown(pilot, "8 points; Enter")
    chart_view = chart_of(pilot, "map-chart")
    assert chart_view.chart is not None
    assert chart_view.chart.backdrop is not None
    assert chart_view.chart.note == "safe μ"
    # A swatch of the scale has the colour of the cells: that of characters, or of a picture.
    scale = pilot.app.screen.query_one(ShadeScale)
    (shade,) = (shade for shade in chart_view.chart.backdrop.shades if shade.text)
    (swatch, *_) = scale.render_line(0)
    assert swatch.text == shade.character
    assert swatch.style is not None
    assert swatch.style.color == chart_view._style(shade.style).color
    chart_view.is_covered = True
    await pilot.pause()
    (swatch, *_) = scale.render_line(0)
    with screen_colours(chart_view.plot_colours()):
        assert swatch.style is not None
        assert swatch.style.color is not None
        assert swatch.style.color.get_truecolor().hex == shade.figure_colour
    # The lines of the scale, and so the size of the chart, stay.
    assert len(swatch.text) == len(shade.character)
    chart_view.is_covered = False
    pane = lab_of(pilot).tab_book.pane
    assert pane is not None
    assert "--value safe-mu" in pane.command_line()
    await click_view(pilot, "coexistence")
    await until_shown(pilot, "F10 maps 744 points")
    range_input.value = "F=100:120:3 mu=0.3:0.9:5"
    range_input.focus()
    await pilot.press("enter")
    await until_shown(pilot, "15 points; ")
    await clear_notices(pilot)
    await until_shown(pilot, "█ squeals")
    # Each map is kept until the next one of its value.
    await click_view(pilot, "safe-mu")
    await until_shown(pilot, "8 points; ")
    await type_into(pilot, "c1", "0.4")
    await until_shown(pilot, "of c1=0.32 (now 0.4): F10 computes again; 8 points")

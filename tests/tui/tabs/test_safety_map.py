"""Maps of safe friction in the laboratory: their shades and scale, and one start of the app."""

from dataclasses import replace

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui import Parameters, safety_map
from fivtui.charts import NO_VALUE, Shade, grade_values, label_shades, scale_text
from fivtui.charts.chart import Cursors, View
from fivtui.maps import StabilityMap
from fivtui.maps.charts import map_chart, region_levels, shown_offsets
from fivtui.maps.searched_points import SearchedPoint
from fivtui.tui.chart.picture import draw
from fivtui.tui.tabs.requests.map import map_request
from fivtui.tui.tabs.studies.map import thin_values
from tests.support.laboratory import chart_of, clear_notices, until_shown


@pytest.fixture(scope="module")
def regions() -> StabilityMap:
    over = {"F": np.array([120.0, 110.0, 100.0]), "mu": np.linspace(0.1, 0.9, 9)}
    return safety_map(None, over, "coexistence")


def scale_of(result: StabilityMap) -> str:
    backdrop = map_chart(result).backdrop
    assert backdrop is not None
    return scale_text(backdrop.shades)


def test_a_map_of_coexistence_has_three_kinds_of_shades(regions: StabilityMap) -> None:
    chart = map_chart(regions, Parameters(F=110.0))
    scale = scale_of(regions)
    assert scale.startswith("· safe ░ ≥")
    assert scale.endswith(" m █ squeals")
    backdrop = chart.backdrop
    assert backdrop is not None
    assert np.all(np.diff(backdrop.x) > 0.0)
    # Along μ at the smallest preload: safe, unsafe after a knock, squealing.
    drawn = [backdrop.shades[level][0] for level in backdrop.levels[0]]
    assert drawn[0] == "·"
    assert set("░▒▓") & set(drawn[1:-1])
    assert drawn[-1] == "█"
    read = draw(chart, View(cursors=Cursors((100.0, 0.9))), 80, 24).text()
    assert "escapes from 0" in read


def test_the_escape_offset_is_zero_where_the_slider_squeals(regions: StabilityMap) -> None:
    values = shown_offsets(regions)
    assert np.isnan(values[regions.regions == 0.0]).all()
    assert np.all(values[regions.regions == 2.0] == 0.0)
    inside = values[regions.regions == 1.0]
    assert np.all((inside > 0.0) & np.isfinite(inside))


def test_a_scale_gives_the_upper_value_of_each_shade() -> None:
    shades = (Shade(" ", "trace-1"), Shade("░", "trace-1"), NO_VALUE)
    values = np.array([[0.25, 0.5], [0.75, np.nan]])
    levels = np.array([[0, 0], [1, 2]])
    assert scale_text(label_shades(levels, shades, values)) == "blank ≤0.5 ░ ≤0.75 ? none"
    # Enough digits to distinguish levels.
    close = np.array([[0.27785, 0.27785], [0.27791, np.nan]])
    assert scale_text(label_shades(levels, shades, close)) == "blank ≤0.2778 ░ ≤0.2779 ? none"


@pytest.fixture(scope="module")
def flat() -> StabilityMap:
    return safety_map(None, {"F": [80.0, 120.0], "k_nl": [95.0, 105.0]})


def test_negligible_differences_have_one_shade(flat: StabilityMap) -> None:
    # The relative difference of the folds is 2e-4.
    assert 0.0 < np.ptp(flat.safe_mu) < 1e-3 * flat.safe_mu.max()
    chart = map_chart(flat, None)
    assert chart.note == "safe μ"
    assert chart.backdrop is not None
    assert np.unique(chart.backdrop.levels).size == 1
    assert scale_of(flat).split() == ["▒", "≤0.278"]
    axes, bar = flat.figure().axes
    assert list(axes.texts) == []
    low, high = bar.get_ylim()
    assert high - low == pytest.approx(1e-3 * flat.safe_mu.max())
    # Larger differences have shades of their own, and a plateau has one shade.
    plateau = np.array([[0.2778, 0.27785, 0.2779, 0.4], [0.2778, 0.9, 0.9001, np.nan]])
    levels, shades = grade_values(plateau)
    assert len({*levels[0, :3].tolist(), levels[1, 0]}) == 1
    assert levels[0, 0] < levels[0, 3] < levels[1, 1] == levels[1, 2]
    assert shades[levels[1, 3]] == NO_VALUE
    ramp, _ = grade_values(np.linspace(0.1, 1.0, 60))
    assert np.bincount(ramp).tolist() == [10] * 6
    # The escaping offsets are accurate to 2 %.
    knock, _ = region_levels(np.ones((1, 3)), np.array([[1.0, 1.03, 3.0]]))
    assert knock.tolist() == [[knock[0, 0], knock[0, 0], 1]]
    assert knock[0, 0] > 1


def test_a_map_distinguishes_missing_from_unknown_safe_friction(flat: StabilityMap) -> None:
    safe = flat.safe_mu.copy()
    critical = flat.critical_mu.copy()
    safe[0], critical[0, 0] = np.nan, np.nan
    quantities = {"safe_mu": safe, "critical_mu": critical}
    partly = replace(flat, quantities=quantities, searched=())
    assert partly.unknown.tolist() == [[False, True], [False, False]]
    assert scale_of(partly).endswith("? none × not known")
    for position, reading in (((80.0, 95.0), "none"), ((80.0, 105.0), "not known")):
        view = View(cursors=Cursors(position))
        assert f"safe μ {reading}" in draw(map_chart(partly, None), view, 80, 24).text()
    (legend,) = partly.figure().legends
    assert {"none", "not known"} <= {text.get_text() for text in legend.get_texts()}
    # Without critical μ, a search that contradicts the result also makes it unknown.
    refuted = replace(partly, searched=(SearchedPoint((0, 0), 0.2),))
    assert refuted.unknown.tolist() == [[True, True], [False, False]]
    only = replace(partly, quantities=quantities | {"critical_mu": flat.critical_mu})
    assert "none" not in scale_of(only)
    assert scale_of(only).endswith("× not known")
    region = {"region": np.where(np.isnan(safe), np.nan, 1.0)}
    regions = replace(only, value="coexistence", quantities={**only.quantities, **region})
    assert "not known" in scale_of(regions)
    none = np.full((2, 2), np.nan)
    lifted = replace(regions, excess=none, quantities={**regions.quantities, "region": none})
    assert scale_of(lifted) == "? no equilibrium"


def test_the_laboratory_maps_fewer_points_with_the_same_ends() -> None:
    values = np.linspace(0.0, 1.0, 121)
    few = thin_values(values)
    assert few.size < 60
    assert (few[0], few[-1]) == (0.0, 1.0)
    assert thin_values(few) is few


async def test_the_map_tab_offers_safe_friction_and_refuses_it_over_friction(
    pilot: Pilot[None],
) -> None:
    await pilot.press("alt+4")
    await until_shown(pilot, "11253 points")
    over = pilot.app.screen.query_one("#over", Input)
    usual = over.value
    assert "μ=" in usual
    # Proposed ranges are those of an existing map; each kind of values keeps its own.
    await pilot.click("#value-safe-mu")
    assert map_request(over.value, "safe-mu")
    over.value = "F=60:120:4 mu=0.1:0.2:2"
    over.focus()
    await pilot.press("enter")
    await until_shown(pilot, "Safe μ does not depend on μ")
    await pilot.click("#value-growth-rate")
    assert over.value == usual
    await pilot.click("#value-critical-mu")
    over.value = "F=60:120:4 k_nl=90:110:2"
    over.focus()
    await pilot.press("enter")
    await until_shown(pilot, "8 points")
    await pilot.click("#value-growth-rate")
    await until_shown(pilot, "11253 points")
    await pilot.click("#value-safe-mu")
    await until_shown(pilot, "8 points")
    view = chart_of(pilot, "map-chart")
    assert view.chart is not None
    assert view.chart.note == "safe μ"
    await pilot.click("#value-coexistence")
    over.value = "F=100:120:3 mu=0.3:0.9:5"
    over.focus()
    await pilot.press("enter")
    await until_shown(pilot, "15 points; ")
    await clear_notices(pilot)
    await until_shown(pilot, "█ squeals")

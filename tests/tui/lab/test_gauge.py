"""The gauge of safe and unsafe values: its drawing, and its updates after edits."""

import threading
from itertools import pairwise
from typing import Any
from unittest.mock import Mock

import pytest
from hypothesis import example, given, strategies as st
from textual.pilot import Pilot

from fivtui.safety import SafeFriction, Zone, Zones, linear_zones, safety_zones
from fivtui.tui.lab.control.gauge_control import GaugeController
from fivtui.tui.lab.screen import LabScreen
from fivtui.tui.lab.verdict.gauge import Gauge, GaugeView, round_range
from fivtui.tui.session import Attractors, Session
from tests.support.laboratory import (
    app_of,
    focus,
    text_of,
    type_into,
    until,
    until_hidden,
    until_screen,
    until_shown,
)

SIZE = (80, 24)
OVER_MU = Zones("mu", (0.0, 0.278, 0.439, 1.5), (Zone.SAFE, Zone.KNOCK, Zone.SQUEALS))


def gauge_of_mu(value: float, text: str) -> Gauge:
    # `basis` names the methods that found the zones.
    return Gauge("μ", OVER_MU, value, text, searching=False, basis="")


def draw_gauge(gauge: Gauge, width: int) -> tuple[str, str]:
    zones, numbers = gauge.lines(width)
    return zones.plain, numbers.plain


@pytest.mark.parametrize("width", [30, 76, 196])
@pytest.mark.parametrize("value", [0.0, 0.28, 0.7, 1.5])
def test_zones_are_drawn_at_their_values_with_labels_and_glyphs(width: int, value: float) -> None:
    gauge = gauge_of_mu(value, f"{value:g}")
    zones, numbers = draw_gauge(gauge, width)
    assert len(zones) == width
    assert len(numbers) == width
    bar_width = width - 2
    marker_column = zones.index("●") - 2
    assert abs(marker_column / (bar_width - 1) - value / 1.5) <= 1.0 / bar_width
    # Each zone has a glyph of its own, so colour adds no information.
    assert zones.index("─") < zones.index("━")
    assert "╍" in zones or width == 30
    assert f"{value:g}" in numbers.split()
    if width == 196:
        assert numbers.split() == sorted({"0", "0.278", "0.439", "1.5", f"{value:g}"}, key=float)
        for label in ("safe", "after a knock", "squeals by itself"):
            assert f" {label} " in zones


@pytest.mark.parametrize("value", [0.0, 0.13, 0.28, 0.35, 0.9, 1.5])
def test_bounds_are_drawn_at_their_values_at_every_width(value: float) -> None:
    gauge = gauge_of_mu(value, f"{value:g}")
    for width in range(20, 140):
        zones, _ = draw_gauge(gauge, width)
        assert len(zones) == width
        for bound in (0.278, 0.439):
            # Columns 2 to width - 1 show values from 0 to 1.5.
            assert zones[2 + round(bound / 1.5 * (width - 3))] in "┼●", (width, zones)


def test_each_number_stands_below_its_bound() -> None:
    zones, numbers = draw_gauge(gauge_of_mu(0.7, "0.70"), 100)
    for number, mark in (("0.278", "┼"), ("0.439", "┼"), ("0.70", "●")):
        column = numbers.index(number)
        assert mark in zones[column : column + len(number)]


def test_numbers_are_centred_below_their_columns_where_there_is_room() -> None:
    _, numbers = draw_gauge(gauge_of_mu(0.9, "0.9000"), 196)
    for text in ("0.278", "0.439", "0.9000"):
        # Columns 2 to 195 show values from 0 to 1.5.
        centre = numbers.index(text) - 2 + 0.5 * (len(text) - 1)
        assert abs(centre - float(text) / 1.5 * 193) <= 1.0


def test_a_value_from_a_computation_is_rounded() -> None:
    text = "0.615668539036192"
    _, numbers = draw_gauge(gauge_of_mu(float(text), text), 100)
    assert "0.61567" in numbers.split()


@st.composite
def gauges(draw: st.DrawFn) -> Gauge:
    """Gauges over ranges of any magnitude, whose bounds and value may nearly coincide.

    Four digits of a bound tell it from the end of its range, as ranges are as wide as their values.
    """
    low = draw(st.sampled_from([0.0, -150.0, 0.7, 5e-12]))
    span = draw(st.sampled_from([span for span in (1.5, 150.0, 3e-5, 7.5e8) if span >= abs(low)]))
    shares = st.one_of(st.floats(0.0, 1.0), st.sampled_from([0.3, 0.3001, 0.30000001, 0.5]))
    bounds = sorted(
        {low, low + span, *(low + span * share for share in draw(st.lists(shares, max_size=6)))}
    )
    zones = draw(st.lists(st.sampled_from(Zone), min_size=6, max_size=6))[: len(bounds) - 1]
    zones += [Zone.SAFE] * (len(bounds) - 1 - len(zones))
    value = draw(st.one_of(st.sampled_from(bounds), shares.map(lambda share: low + span * share)))
    text = draw(st.sampled_from([f"{value:.3g}", repr(value)]))
    over_range = Zones("mu", tuple(bounds), tuple(zones))
    return Gauge("F (N)", over_range, float(text), text, searching=False, basis="")


def gauge_over(bounds: tuple[float, ...], value: float) -> Gauge:
    # SMALL: small disturbances die out, large ones were not searched.
    zones = (Zone.SAFE, Zone.KNOCK, Zone.SMALL, Zone.SQUEALS)
    over_mu = Zones("mu", (0.0, *bounds, 30.0), zones)
    return Gauge("μ", over_mu, value, f"{value:g}", searching=False, basis="")


@example(gauge_over((16.0, 17.1, 17.149), 17.12), 40)
@example(gauge_over((15.3, 16.0, 16.4), 16.001), 30)
@example(gauge_over((17.1, 17.149, 29.5), 0.5), 76)
@given(gauges(), st.integers(20, 200))
def test_numbers_ascend_and_stay_apart(gauge: Gauge, width: int) -> None:
    bar, line = draw_gauge(gauge, width)
    assert len(bar) == len(line) == width
    numbers = [float(number) for number in line.split()]
    assert all(low < high for low, high in pairwise(numbers))
    # The numbers are the value and bounds, rounded.
    exact_values = (gauge.value, *gauge.zones.bounds)
    for number in numbers:
        assert any(abs(number - exact) <= 0.01 * abs(exact) for exact in exact_values)
    if width >= 40:
        shown_value = pytest.approx(gauge.value, rel=1e-4)
        assert any(number == shown_value for number in numbers)


@given(gauges(), st.integers(20, 200), st.data())
def test_the_mouse_moves_the_marker_to_a_short_number_in_its_column(
    gauge: Gauge, width: int, data: st.DataObject
) -> None:
    first = len("F (N) ")
    column = data.draw(st.integers(first, width - 1))
    text = gauge.text_at(column, 0, width)
    value = float(text)
    bounds = gauge.zones.bounds
    assert text == gauge.text or value in bounds or len(text) <= 12
    tolerance = 1.0 + 1e-3 * width
    bar_width = width - first
    share = (value - bounds[0]) / (bounds[-1] - bounds[0])
    assert abs(share * (bar_width - 1) - (column - first)) <= tolerance
    # Outside the bar, the mouse moves the marker to its ends.
    for outside, end in ((-50, bounds[0]), (width + 50, bounds[-1])):
        assert float(gauge.text_at(outside, 0, width)) in (end, gauge.value)


def test_a_click_on_a_bound_moves_to_its_safer_side() -> None:
    # 0.27788 is displayed as 0.278, where a knock is enough to squeal.
    over_mu = Zones("mu", (0.0, 0.27788, 0.43941, 1.5), (Zone.SAFE, Zone.KNOCK, Zone.SQUEALS))
    gauge = Gauge("μ", over_mu, 0.7, "0.7", searching=False, basis="")
    bar, numbers = draw_gauge(gauge, 76)
    for label, text in (("0.278", "0.2778"), ("0.439", "0.4394"), ("1.5", "1.5"), ("0.7", "0.7")):
        assert gauge.text_at(numbers.index(label), 1, 76) == text
    assert gauge.text_at(bar.index("┼"), 0, 76) == "0.2778"
    assert gauge.text_at(bar.rindex("┼"), 0, 76) == "0.4394"
    assert gauge.text_at(bar.index("●"), 0, 76) == "0.7"
    # On this bar the value of a load falls from squeal to safety.
    over_load = Zones("F", (0.0, 85.1234, 150.0), (Zone.SQUEALS, Zone.SAFE))
    load_gauge = Gauge("F (N)", over_load, 80.0, "80", searching=False, basis="")
    bar, _ = draw_gauge(load_gauge, 76)
    assert load_gauge.text_at(bar.index("┼"), 0, 76) == "85.13"


def test_unknown_and_impossible_values_are_labelled() -> None:
    zones = Zones("F", (0.0, 10.0, 20.0), (Zone.SMALL, Zone.NONE))
    line_during_search, _ = draw_gauge(
        Gauge("F (N)", zones, 5.0, "5", searching=True, basis=""), 150
    )
    assert "large disturbances: searching…" in line_during_search
    line_after_search, _ = draw_gauge(
        Gauge("F (N)", zones, 5.0, "5", searching=False, basis=""), 150
    )
    assert "large disturbances: not known" in line_after_search
    assert "not possible" in line_after_search


def test_ranges_are_round_and_stay_while_a_value_is_stepped() -> None:
    assert round_range(80.0, -1e9, 1e9) == (0.0, 150.0)
    assert {round_range(F, -1e9, 1e9) for F in (70.0, 80.0, 100.0)} == {(0.0, 150.0)}
    assert round_range(-80.0, -1e9, 1e9) == (-150.0, 150.0)
    assert round_range(0.0, 0.0, 1e9) == (0.0, 1.0)
    assert round_range(1e9, 0.0, 1e9) == (0.0, 1e9)


async def test_the_gauge_follows_the_edited_field(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    search_started, search_may_end = threading.Event(), threading.Event()

    def search_when_released(*args: Any, progress: Any = None, **named: Any) -> Zones:
        search_started.set()
        search_may_end.wait()
        return safety_zones(*args, **named)

    monkeypatch.setattr("fivtui.safety.safety_zones", search_when_released)
    # A changed scene is searched anew; the search for the first one was cancelled.
    await type_into(pilot, "k_nl", "99")
    await focus(pilot, "mu")
    # Eigenvalues are shown at once; values not yet searched are not called safe.
    await until_screen(pilot, lambda text: "searching…" in gauge_line(text))
    await pilot.press("up")
    await until(pilot, search_started.is_set)
    await until_screen(pilot, lambda text: " 0.71 " in text and "safe" not in gauge_line(text))
    search_may_end.set()
    await until_screen(pilot, lambda text: " safe " in gauge_line(text))
    initial_column = gauge_line(text_of(pilot)).index("●")
    await pilot.press(*["down"] * 3)
    await until_screen(pilot, lambda text: gauge_line(text).index("●") < initial_column)
    monkeypatch.setattr("fivtui.safety.safety_zones", linear_zones)
    # The gauge of μ stays; where there is room, that of the parameter edited last is below it.
    await focus(pilot, "F")
    await until_screen(
        pilot, lambda text: gauge_line(text).startswith("│ μ ") and "F (N) " not in text
    )
    await pilot.resize_terminal(80, 30)
    await until_screen(pilot, lambda text: gauge_line(text).startswith("│ μ ") and "F (N) " in text)
    # Elsewhere the facts are in its place, and on a high screen it is below them.
    await until_hidden(pilot, "μ_c 0.4")
    await focus(pilot, "t_end")
    await until_screen(pilot, lambda text: "μ_c 0.4" in text and "F (N) " not in text)
    await pilot.resize_terminal(80, 36)
    await until_screen(pilot, lambda text: "μ_c 0.4" in text and "F (N) " in text)


def test_ranges_follow_from_the_scene_and_the_value_alone() -> None:
    def ranges(*texts: str) -> list[tuple[float, float]]:
        session = Session()
        controller = GaugeController(Mock(spec=LabScreen, session=session))
        gauges: list[Gauge | str] = []
        for text in texts:
            for name in ("F", "mu"):
                session.set_text(name, text)
            gauges = controller.gauges(session.stability(), Attractors(), both=True)
        bounds = [gauge.zones.bounds for gauge in gauges if isinstance(gauge, Gauge)]
        return [(low, high) for low, *_, high in bounds]

    for path in (("0.7", "50", "4"), ("1", "4"), ("4.4", "2", "4")):
        assert ranges(*path) == ranges("4") == [(0.0, 10.0), (0.0, 7.5)], path


async def test_the_mouse_drags_the_value_in_one_undo_step(pilot: Pilot[None]) -> None:
    session, gauge = app_of(pilot).session, pilot.app.screen.query_one(GaugeView)
    await pilot.press("up")
    marker = gauge_line(text_of(pilot)).index("●") - gauge.region.x
    await pilot.mouse_down(gauge, offset=(marker, 0))
    # The marker does not move before the mouse does.
    assert session.texts["mu"] == "0.71"
    for column in (30, 22, 60):
        await pilot.hover(gauge, offset=(column, 1))
        await pilot.pause()
        await until_screen(
            pilot,
            lambda text: (
                gauge_line(text).index("●") == gauge.region.x + column  # noqa: B023
                and f"•μ     {session.texts['mu']}" in text
            ),
        )
    assert session.texts["mu"] == "1.2"
    await until_shown(pilot, "growth rate +1.061")
    await pilot.mouse_up(gauge, offset=(60, 0))
    # After the release, the mouse only hovers.
    await pilot.hover(gauge, offset=(20, 0))
    await pilot.press("up")
    assert session.texts["mu"] == "1.3"
    for text in ("1.2", "0.71", "0.7"):
        await pilot.press("ctrl+z")
        await until(pilot, lambda: session.texts["mu"] == text)  # noqa: B023


async def test_the_range_stays_while_the_marker_is_dragged(pilot: Pilot[None]) -> None:
    def last_number() -> str:
        lines = text_of(pilot).splitlines()
        (row,) = (row for row, line in enumerate(lines) if "F (N) " in line)
        return lines[row + 1].strip("│ ").split()[-1]

    await pilot.resize_terminal(80, 30)
    await focus(pilot, "F")
    await until_screen(pilot, lambda text: "F (N) " in text)
    gauge = pilot.app.screen.query_one("#gauge-beside", GaugeView)
    await pilot.mouse_down(gauge, offset=(20, 0))
    await pilot.hover(gauge, offset=(8, 0))
    await until(pilot, lambda: app_of(pilot).session.texts["F"] == "4")
    assert last_number() == "150"
    await pilot.mouse_up(gauge, offset=(8, 0))
    await until_screen(pilot, lambda _: last_number() == "7.5")


def gauge_line(text: str) -> str:
    return next(line for line in text.splitlines() if "●" in line)


@pytest.mark.parametrize(
    ("confirmed_to", "zone"),
    [(0.05, Zone.SMALL), (0.3, Zone.SAFE), (None, Zone.SAFE)],
    ids=["contradicted", "confirmed", "not searched yet"],
)
def test_a_search_over_mu_that_contradicts_continuation_leaves_no_preload_safe(
    confirmed_to: float | None, zone: Zone
) -> None:
    # At μ = 0.2 continuation finds F = 75 to 100 N safe. A search at F = 80 N that confirms only
    # μ up to 0.05 as safe contradicts it.
    session = Session()
    session.set_text("mu", "0.2")
    controller = GaugeController(Mock(spec=LabScreen, session=session))
    controller.focus("F")
    safe = (
        None
        if confirmed_to is None
        else Mock(
            spec=SafeFriction,
            system=session.stability().system,
            safe_to=confirmed_to,
            others=(),
            critical_mu=0.4,
        )
    )
    # State of that search: `complete` if it has ended.
    attractors = Attractors(safe=safe, complete=safe is not None)
    _, eigenvalue_gauge = controller.gauges(session.stability(), attractors, both=True)
    assert isinstance(eigenvalue_gauge, Gauge)
    # Eigenvalues alone do not show that a value is safe.
    assert eigenvalue_gauge.searching
    assert eigenvalue_gauge.zones.at(80.0) is Zone.SMALL
    gauge_range = controller._queue[-1]
    continuation_zones = Zones(
        "F",
        (gauge_range.low, 75.0, 100.0, gauge_range.high),
        (Zone.KNOCK, Zone.SAFE, Zone.SQUEALS),
    )
    controller.store(gauge_range, continuation_zones)
    _, gauge = controller.gauges(session.stability(), attractors, both=True)
    assert isinstance(gauge, Gauge)
    assert [gauge.zones.at(F) for F in (70.0, 80.0, 120.0)] == [Zone.KNOCK, zone, Zone.SQUEALS]
    # Continuation finds F = 70 unsafe, so the search does not contradict it.
    session.set_text("F", "70")
    _, gauge_at_70 = controller.gauges(session.stability(), attractors, both=True)
    assert isinstance(gauge_at_70, Gauge)
    assert gauge_at_70.zones.at(80.0) is Zone.SAFE


async def test_a_scene_with_tables_over_time_has_no_zones(pilot: Pilot[None]) -> None:
    await pilot.press("ctrl+p")
    await pilot.press(*"brake-stop")
    await until_shown(pilot, "Preset brake-stop")
    await pilot.press("enter")
    await until_shown(pilot, "no zones: F, v_belt change over time")
    # The text takes no drags.
    await pilot.mouse_down(GaugeView)
    await pilot.pause()
    assert pilot.app.mouse_captured is None


async def test_static_friction_bounds_the_gauge(pilot: Pilot[None]) -> None:
    def end_numbers(label: str) -> list[str]:
        lines = text_of(pilot).splitlines()
        row = next(row for row, line in enumerate(lines) if line.startswith(f"│ {label} "))
        numbers = lines[row + 1].strip("│ ").split()
        return [numbers[0], numbers[-1]]

    # Static friction acts only on a belt of finite speed.
    await pilot.resize_terminal(80, 30)
    for name, text in (("v_belt", "1"), ("mu_s", "0.9")):
        await type_into(pilot, name, text)
    # Static friction is at least the sliding friction.
    await until_shown(pilot, "│ μ_s ")
    assert end_numbers("μ_s")[0] == "0.7"
    assert end_numbers("μ") == ["0", "0.9"]

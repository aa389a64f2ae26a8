"""A belt of finite speed in the laboratory: sticking phases and phase portraits."""

import re

from textual.pilot import Pilot

from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import run_to_end, type_into, until, until_screen, until_shown

SIZE = (170, 40)


async def test_stick_is_marked_below_time_histories_and_in_three_portraits(
    pilot: Pilot[None],
) -> None:
    await type_into(pilot, "v_belt", "1")
    await type_into(pilot, "t_end", "20")
    await run_to_end(pilot)
    await until_screen(pilot, lambda text: bool(re.search(" stick.*█|█.* stick", text)))
    pane = pilot.app.screen.query_one(TransientPane)
    pane.show_view("phase")
    await until_shown(pilot, "■stick")
    names = ("phase-y", "phase-x", "phase-path")
    views = [pane.query_one(f"#{name}", ChartView) for name in names]
    await until(pilot, lambda: all(view.chart is not None for view in views))
    charts = [view.chart for view in views if view.chart is not None]
    assert [(chart.x_label, chart.y_label) for chart in charts] == [
        ("y (m)", "ẏ (m/s)"),
        ("x (m)", "ẋ (m/s)"),
        ("x (m)", "y (m)"),
    ]
    assert all("stick" in [trace.name for trace in chart.traces] for chart in charts)
    assert [guide.value for guide in charts[1].guides if guide.label == "belt"] == [1.0]
    # If there is no room for three portraits, the first one remains.
    await pilot.resize_terminal(100, 40)
    await until(pilot, lambda: [view.display for view in views] == [True, False, False])

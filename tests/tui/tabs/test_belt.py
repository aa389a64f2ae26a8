"""The slider on the belt in the laboratory: at the cursor, animated, and written to a file."""

import wave
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui import film
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.export import DATA, FIGURE
from fivtui.tui.tabs.motion.belt import BeltView
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import run_to_end, show_tab, until, until_shown

SIZE = (100, 34)


async def test_the_slider_is_drawn_at_the_time_of_the_cursor_is_animated_and_is_exported(
    pilot: Pilot[None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await show_tab(pilot, "alt+1")
    pane = pilot.app.screen.query_one(TransientPane)
    # Without a run there is no animation.
    pane.query_one(BeltView).action_play()
    assert not pane.query_one(BeltView).playing
    await run_to_end(pilot)
    run = pane.session.runs.displayed
    assert run is not None
    assert run.result is not None
    start, end = run.result.separated_intervals[-2]
    pane.query_one("#plot-y", ChartView).view.cursors.first = (0.5 * (start + end), 0.0)
    pane.show_view("belt")
    view = pane.query_one(BeltView)
    await until_shown(pilot, " s, off the belt, ×1")
    assert view.t == 0.5 * (start + end)
    # The mark ○ is that of a separated slider, ▬ that of a sliding one.
    await until_shown(pilot, "○slider")
    chart = pane.query_one("#belt-picture", ChartView).chart
    assert chart is not None
    slider = next(trace for trace in chart.traces if trace.name == "slider")
    # The outline of the slider ends with the five points of its foot.
    assert slider.y[-5:].min() > 0.0
    # Keys step the time, not below the start.
    await pilot.press(".")
    assert view.t == 0.5 * (start + end) + 0.04
    await pilot.press("home")
    await until_shown(pilot, "0 s, sliding, ×1")
    await pilot.press(",")
    assert view.t == 0.0
    await until_shown(pilot, "▬slider")
    # In real time, then at twice the speed, to the end.
    await pilot.press("space")
    await until(pilot, lambda: view.t > 0.05)
    assert view.playing
    await pilot.press(">")
    await until_shown(pilot, ", ×2")
    await pilot.press("space")
    assert not view.playing
    view.action_go_to(run.result.t_end - 0.01)
    await pilot.press("space")
    await until(pilot, lambda: not view.playing)
    assert view.t == run.result.t_end

    # The film covers the visible times: all, so that it has no window.
    pane.query_one("#plot-y", ChartView).view.x = None
    calls: list[tuple[object, ...]] = []
    monkeypatch.setattr(
        film, "animate", lambda *arguments, **options: calls.append((arguments, options))
    )
    data, figure = pane.export(DATA), pane.export(FIGURE)
    assert (data.file_name, figure.file_name) == ("base-1.wav", "base-1-belt.gif")
    data.check(tmp_path / "a.wav")
    data.write(tmp_path / "a.wav")
    with wave.open(str(tmp_path / "a.wav")) as file:
        assert file.getnframes() > 10_000
    figure.check(tmp_path / "a.gif")
    figure.write(tmp_path / "a.gif")
    assert calls == [((run.result, tmp_path / "a.gif"), {"window": None, "speed": 2.0})]

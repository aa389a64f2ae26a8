"""Measured data in the laboratory: overlay, spectra, band, verdict, refusals, export."""

import numpy as np
from textual.pilot import Pilot
from textual.widgets import Input, Static

from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.exports.export import FIGURE
from fivtui.tui.tabs.motion.measured import MeasuredView
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import run_to_end, until, until_shown


async def test_measured_data_lie_over_the_run_and_pass_or_fail(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    pane = pilot.app.screen.query_one(TransientPane)
    pane.show_view("measured")
    await until_shown(pilot, "no measured data: name a file above")
    run = pane.session.runs.displayed
    assert run is not None
    assert run.result is not None
    known = run.result.trajectory
    assert known is not None
    late = (known.t > 50.0) & (known.t < 70.0)
    data = np.column_stack([known.t[late] - known.t[late][0], 1e3 * known.y[late] + 1.0])
    np.savetxt("rig.csv", data, delimiter=";", header="t;y_mm", comments="")
    view = pane.query_one(MeasuredView)

    words = view.query_one("#overlay-words", Static)
    overlay = view.query_one("#overlay-time", ChartView)

    def said() -> str:
        return f"{words.render()} {overlay.chart.note if overlay.chart else ''}"

    async def put(told: str, **texts: str) -> None:
        for name, text in texts.items():
            field = view.query_one(f"#measured-{name}", Input)
            field.value = text
            field.focus()
        await pilot.press("enter")
        await until(pilot, lambda: told in said())

    await put("missing.csv", file="missing.csv")
    await put("signal column", file="rig.csv", signal="z_mm")
    await put("correlation 1.000", signal="y_mm", scale="1e-3", shift="auto")
    await put("FAIL", band="0.01%")
    await put("PASS: 100.0% within", offset="-1e-3")
    await until_shown(pilot, "PASS: 100.0% within")
    assert pane.setting("measured-file", "") == "rig.csv"
    time, spectrum = (chart.chart for chart in view.query(ChartView))
    assert time is not None
    assert spectrum is not None
    traces = {trace.name: trace for trace in time.traces}
    np.testing.assert_allclose(traces["measured"].y, traces["computed"].y, atol=1e-4)
    np.testing.assert_allclose(traces["measured"].x, known.t[late], atol=1e-4)
    assert "Hz measured" in spectrum.note
    assert pane.export(FIGURE).proposal == "base-1-measured.svg"

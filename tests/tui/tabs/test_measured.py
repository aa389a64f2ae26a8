"""Measured data in the laboratory: overlay, spectra, band, verdict, refusals, export."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input, Static

from fivtui import cli
from fivtui.model.errors import InputError
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.exports.export import DATA, FIGURE
from fivtui.tui.tabs.motion.measured import MeasuredView
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import run_to_end, until, until_shown


async def test_measured_data_lie_over_the_run_and_pass_or_fail(
    pilot: Pilot[None], capsys: pytest.CaptureFixture[str]
) -> None:
    await run_to_end(pilot)
    pane = pilot.app.screen.query_one(TransientPane)
    pane.show_view("measured")
    await until_shown(pilot, "How near does the model come to")
    run = pane.session.runs.displayed
    assert run is not None
    assert run.result is not None
    trajectory = run.result.trajectory
    assert trajectory is not None
    in_window = (trajectory.t > 50.0) & (trajectory.t < 70.0)
    data = np.column_stack(
        [trajectory.t[in_window] - trajectory.t[in_window][0], 1e3 * trajectory.y[in_window] + 1.0]
    )
    np.savetxt("rig.csv", data, delimiter=";", header="t;y_mm", comments="")
    view = pane.query_one(MeasuredView)

    label = view.query_one("#overlay-text", Static)
    overlay = view.query_one("#overlay-time", ChartView)

    def shown_text() -> str:
        return f"{label.render()} {overlay.chart.note if overlay.chart else ''}"

    async def enter_texts(message: str, **texts: str) -> None:
        for name, text in texts.items():
            field = view.query_one(f"#measured-{name.replace('_', '-')}", Input)
            field.value = text
            field.focus()
        await pilot.press("enter")
        await until(pilot, lambda: message in shown_text())

    await enter_texts("missing.csv", file="missing.csv")
    await enter_texts("signal column", file="rig.csv", signal="z_mm")
    await enter_texts("correlation 1.000", signal="y_mm", scale="1e-3", shift="auto")
    await enter_texts("FAIL", band="0.01%")
    await enter_texts("PASS: share within the band 100.000%", offset="-1e-3")
    # The screen shows the verdict, too.
    await until_shown(pilot, "PASS: share within the band 100.000%")
    assert pane.stored_setting("measured-file", "") == "rig.csv"
    time_chart, spectrum_chart = (chart.chart for chart in view.query(ChartView))
    assert time_chart is not None
    assert spectrum_chart is not None
    traces = {trace.name: trace for trace in time_chart.traces}
    np.testing.assert_allclose(traces["measured"].y, traces["computed"].y, atol=1e-4)
    np.testing.assert_allclose(traces["measured"].x, trajectory.t[in_window], atol=1e-4)
    assert "Hz measured" in spectrum_chart.note
    assert pane.export(FIGURE).file_name == "base-1-validation-y.svg"
    pane.export(DATA).write(Path("rig.json"))
    # The copied command validates the same data, with the file and its time unit.
    await enter_texts("must fit into the run", time_scale="10")
    assert pane.command_line().startswith("fivtui validate --measured rig.csv ")
    with pytest.raises(InputError, match="must fit into the run"):
        pane.export(FIGURE)
    await enter_texts("PASS: share", time_scale="1", frequency="1%", amplitude="1%", share="99%")
    arguments = shlex.split(pane.command_line())[1:]
    assert arguments[-6:] == ["--share", "99%", "--frequency", "1%", "--amplitude", "1%"]
    cli.commands.main([*arguments, "--json"], standalone_mode=False)
    command_result, displayed_result = (
        json.loads(capsys.readouterr().out),
        view.validation.to_dict(),
    )
    assert [criterion["name"] for criterion in command_result["criteria"]] == [
        criterion["name"] for criterion in displayed_result["criteria"]
    ]
    assert command_result["passed"] is displayed_result["passed"] is True
    assert command_result["shift"] == pytest.approx(displayed_result["shift"], abs=1e-6)
    assert command_result["deviation"]["rms"] == pytest.approx(
        displayed_result["deviation"]["rms"], abs=1e-4
    )
    assert json.loads(Path("rig.json").read_text())["columns"] == ["t", "y_mm"]
    await enter_texts("must be a percentage", frequency="1")

"""Measured data in the laboratory: overlay, spectra, band, verdict, refusals, export."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui import cli
from fivtui.model.errors import InputError
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.export import DATA, FIGURE
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

    measured_input = view.query_one("#measured-data", Input)

    async def enter_text(message: str, text: str) -> None:
        measured_input.value = text
        measured_input.focus()
        await pilot.press("enter")
        await until_shown(pilot, message)

    await enter_text("missing.csv", "missing.csv")
    await enter_text("signal column", "rig.csv --signal z_mm")
    text = "rig.csv --signal y_mm --scale 1e-3 --shift auto"
    await enter_text("correlation 1.000", text)
    await enter_text("FAIL", f"{text} --band 0.01%")
    text += " --offset -1e-3"
    await enter_text("PASS: share within the band 100.000%", f"{text} --band 0.01%")
    assert pane.stored_setting("measured", "") == f"{text} --band 0.01%"
    time_chart, spectrum_chart = (chart.chart for chart in view.query(ChartView))
    assert time_chart is not None
    assert spectrum_chart is not None
    traces = {trace.name: trace for trace in time_chart.traces}
    np.testing.assert_allclose(traces["measured"].y, traces["computed"].y, atol=1e-4)
    assert np.all(traces["−band"].y < traces["+band"].y)
    np.testing.assert_allclose(traces["measured"].x, trajectory.t[in_window], atol=1e-4)
    assert "Hz measured" in spectrum_chart.note
    assert pane.export(FIGURE).file_name == "base-1-validation-y.svg"
    pane.export(DATA).write(Path("rig.json"))
    # The copied command validates the same data, with the file and its time unit.
    await enter_text("for an automatic shift it must", f"{text} --time-scale 10")
    assert pane.command_line().startswith("fivtui validate --measured rig.csv ")
    with pytest.raises(InputError, match="must fit into the run"):
        pane.export(FIGURE)
    # The overlay of the last valid input stays, also beside another run.
    view.show_run(run.result)
    assert all(chart_view.chart is not None for chart_view in view.query(ChartView))
    tolerances = "--band 0.01% --share 99% --frequency 1% --amplitude 1%"
    await enter_text("PASS: share", f"{text} {tolerances}")
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


async def test_one_key_and_the_name_of_a_file_lay_measured_data_over_the_motion(
    pilot: Pilot[None],
) -> None:
    Path("bench").mkdir()
    Path("bench/rig.csv").write_text("t,y\n" + "".join(f"{t},0.1\n" for t in range(50)))
    Path("bench/notes.txt").write_text("")
    await until(pilot, lambda: pilot.app.screen.focused is not None)
    await pilot.press("m")
    measured_input = pilot.app.screen.query_one("#measured-data", Input)
    await until(pilot, lambda: measured_input.has_focus)
    # The grey text is the rest of a path, or of an option.
    for typed, completed in (("b", "bench/"), ("", "bench/rig.csv"), (" --ba", "--band")):
        await pilot.press(*({" ": "space", "-": "minus"}.get(key, key) for key in typed))
        await until(pilot, lambda: measured_input._suggestion.endswith(completed))  # noqa: B023
        await pilot.press("right")
    await pilot.press("space", "5", "enter")
    await until_shown(pilot, "FAIL: share within the band")

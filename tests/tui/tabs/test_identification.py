"""The fit tab: a fit, its progress and its end, both signals, values in the form, exports."""

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui import cli, identify
from fivtui.model import InputError, Parameters
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.persistence.results import ResultStore
from fivtui.tui.session.session import DisplayedStudy
from fivtui.tui.tabs.export import DATA, FIGURE
from fivtui.tui.tabs.studies import identification
from fivtui.tui.tabs.studies.identification import IdentificationPane
from fivtui.tui.tabs.tables import RowsView
from tests.support.laboratory import (
    app_of,
    endless_simulate,
    show_tab,
    until,
    until_notice,
    until_shown,
)

SIZE = (120, 40)
RIG = Parameters(mu=0.62, c1=0.4)
TEXT = "rig.csv --signal y --signal x --fit μ --fit c1=0.1:2"


@pytest.fixture(autouse=True)
def write_record(pilot: Pilot[None]) -> None:
    """A record of the first 10 s of a rig, with noise, in the laboratory's folder."""
    motion = simulate(RIG, t_end=10.0, samples=501).trajectory
    assert motion is not None
    noise = np.random.default_rng(3).normal(0.0, 0.02, (2, motion.t.size))
    columns = np.column_stack([motion.t, motion.y + noise[0], motion.x + noise[1]])
    np.savetxt("rig.csv", columns, delimiter=",", header="t,y,x", comments="")


async def enter(pilot: Pilot[None], text: str) -> IdentificationPane:
    await show_tab(pilot, "alt+9")
    pane = pilot.app.screen.query_one(IdentificationPane)
    pane.query_one("#identification-input", Input).value = text
    return pane


async def fit(pilot: Pilot[None], text: str) -> IdentificationPane:
    pane = await enter(pilot, text)
    await pilot.press("f10")
    return pane


def stored_and_read(displayed: DisplayedStudy[Any]) -> DisplayedStudy[Any]:
    files, notes = ResultStore(Path("kept")).save({"identification": displayed})
    assert notes == {}
    read = ResultStore(Path("kept")).read(files)[0]["identification"]
    assert isinstance(read, DisplayedStudy)
    return read


async def test_a_fit_is_shown_beside_its_residuals_and_enter_runs_the_fitted_values(
    pilot: Pilot[None],
) -> None:
    pane = await fit(pilot, TEXT)
    await until_shown(pilot, "μ 0.6")
    (displayed,) = app_of(pilot).session.studies.values()
    result = displayed.value
    assert (
        result.fit == identify(measured="rig.csv", fit=["mu", "c1=0.1:2"], signals=["y", "x"]).fit
    )
    signals, residuals = pane.query(ChartView)
    labels = []
    for _ in range(3):
        assert signals.chart is not None
        assert residuals.chart is not None
        labels.append(signals.chart.y_label)
        computed, measured = signals.chart.traces
        (deviation,) = residuals.chart.traces
        np.testing.assert_array_equal(measured.y - computed.y, deviation.y)
        await pilot.press("alt+p", "s")
    assert labels == ["y (m)", "x (m)", "y (m)"]
    await pilot.press("v")
    await until_shown(pilot, f"{result.fit['mu'].value:.6g} 95 %: {result.fit['mu'].low:.6g} to")
    assert pane.query_one(RowsView).display
    await pilot.press("enter")
    session = app_of(pilot).session
    await until(pilot, lambda: session.runs.newest is not None and session.runs.active is None)
    run = session.runs.newest
    assert run is not None
    assert run.scene.parameters == result.parameters
    assert session.scene().parameters == result.parameters


async def test_a_fit_is_exported_and_its_command_gives_the_same_values(
    pilot: Pilot[None], capsys: pytest.CaptureFixture[str]
) -> None:
    pane = await enter(pilot, TEXT)
    # Without a result there is nothing to apply, to draw or to export; the command computes the
    # edited scene.
    pane.action_apply_values()
    pane.action_next_signal()
    with pytest.raises(InputError, match="press Fit"):
        pane.export(DATA)
    arguments = shlex.split(pane.command_line())
    await pilot.press("f10")
    await until_shown(pilot, "μ 0.6")
    assert not pane.has_class("-outdated")
    figure, data = pane.export(FIGURE), pane.export(DATA)
    assert tuple(data.writers) == (".toml", ".json")
    assert data.file_name == "base-fitted-mu-c1.toml"
    figure.write(Path("fit.svg"))
    assert "<!-- computed -->" in Path("fit.svg").read_text()
    data.write(Path("fit.json"))
    # The command is that of the displayed result, not of what was entered after it.
    pane.query_one("#identification-input", Input).value = "other.csv --fit F"
    app_of(pilot).session.set_text("mu", "0.3")
    assert shlex.split(pane.command_line()) == arguments
    assert arguments[1:] == [
        "identify", "--measured", "rig.csv", "--signal", "y", "--signal", "x", "--fit", "mu",
        "--fit", "c1=0.1:2",
    ]  # fmt: skip
    assert cli.run([*arguments[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(Path("fit.json").read_text())
    # A closed laboratory stores the fit, and repeats its command when it is opened.
    session = app_of(pilot).session
    restored = stored_and_read(session.studies["identification"])
    assert restored.value == session.studies["identification"].value
    session.studies["identification"] = restored
    assert shlex.split(pane.command_line()) == arguments


async def test_what_data_leave_unknown_is_said_in_place_of_the_values(pilot: Pilot[None]) -> None:
    pane = await fit(
        pilot, "--target critical-mu=0.45±0.01 --target frequency=0.92±0.01 --fit F --fit k_nl"
    )
    await until_shown(pilot, "only combinations of")
    displayed = app_of(pilot).session.studies["identification"]
    assert stored_and_read(displayed).value.to_dict() == displayed.value.to_dict()
    # Targets have no signals to draw.
    assert pane.visible_charts() is None
    with pytest.raises(InputError, match="a fit to targets alone has no figure"):
        pane.export(FIGURE).write(Path("fit.svg"))


async def test_a_fit_can_be_stopped(pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identification, "prepare_fit", lambda *_: endless_simulate)
    pane = await fit(pilot, TEXT)
    await until_shown(pilot, "Stop")
    assert pane.job is not None
    await pilot.press("f10")
    await until(pilot, lambda: pane.job is None)
    await until_shown(pilot, "stopped")
    assert not app_of(pilot).session.studies


async def test_a_wrong_file_or_option_is_one_line(pilot: Pilot[None]) -> None:
    await fit(pilot, "none.csv --fit mu")
    await until_notice(pilot, "none.csv")
    for text, message in (
        ("rig.csv", "--fit NAME: must be given"),
        ("rig.csv --fit q", "unknown parameter 'q'"),
        ("rig.csv --fit mu=2:1", "LOW must be below HIGH"),
        ("rig.csv --fit", "--fit: must be followed by a value"),
        ("rig.csv --fit mu --target critical-mu=1", "must be NAME=VALUE±SD"),
        ("rig.csv --fit mu --noise x", "--noise = 'x': not a number"),
        ("'rig.csv --fit mu", "No closing quotation"),
        ("--fit mu --own F", "--own F: must be given with --measured"),
    ):
        await fit(pilot, text)
        await until_shown(pilot, message)


def test_files_may_have_blanks_and_backslashes() -> None:
    text = r"'my rig.csv' C:\rig\b.csv --measured c.csv --fit k_1=1:2"
    _, options = IdentificationPane.parse(PRESETS["base"], text)
    assert [str(path) for path in options.measured] == ["my rig.csv", r"C:\rig\b.csv", "c.csv"]
    assert options.fit == ("k1=1:2",)

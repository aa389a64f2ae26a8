"""The list of runs, the comparison of engines, and the session after a restart."""

import dataclasses
import json
from pathlib import Path

import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.model.errors import Cancelled
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.transient import integrate
from fivtui.transient.files import save_trajectory
from fivtui.transient.request import Request
from fivtui.transient.result import Transient
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.lab.run_list import RunsTable
from tests.support.laboratory import (
    answer,
    app_of,
    click_view,
    focus,
    run_to_end,
    type_into,
    until,
    until_hidden,
    until_notice,
    until_shown,
)

SIZE = (140, 48)


async def test_runs_are_listed_drawn_compared_loaded_and_deleted(
    pilot: Pilot[None], tmp_path: Path
) -> None:
    app = app_of(pilot)
    runs = app.session.runs
    await run_to_end(pilot)
    await type_into(pilot, "F", "40")
    await run_to_end(pilot)
    await until_shown(pilot, "■ 2 shown native")
    await until_shown(pilot, "● 1 off native 10.50")
    # In the list of runs: go down to run 1, plot it, and make it the baseline.
    await pilot.press("f3", "j", "space", "b")
    await until_shown(pilot, "● 1 on native 10.50 base")
    first, second = runs
    assert runs.plotted == [first, second]
    assert second.result is not None
    assert first.result is not None
    percent = 100.0 * (second.result.peak.y_abs / first.result.peak.y_abs - 1.0)
    await until_shown(pilot, f"{percent:+.3g}")
    await click_view(pilot, "result")
    await until_shown(pilot, "baseline run 1 run 2 − run 1:")
    await until_shown(pilot, "from 10.50 m")
    await pilot.press("f3", "c", "m")
    await until_shown(pilot, "■ 1 on")
    assert first.colour_shift == 1

    await pilot.press("enter")
    await until_shown(pilot, "1 shown")
    await until(pilot, lambda: app.session.texts["F"] == "80")
    await pilot.press("ctrl+z")
    await until(pilot, lambda: app.session.texts["F"] == "40")
    await pilot.press("k", "x")
    await until_notice(pilot, "run 2 deleted")
    assert list(runs) == [first]
    await pilot.press("ctrl+z")
    await until_shown(pilot, "■ 2")
    assert list(runs) == [first, second]
    assert app.session.texts["F"] == "40"
    await pilot.press("ctrl+y")
    await until(pilot, lambda: list(runs) == [first])
    await click_view(pilot, "time")
    view = app.screen.query_one("#plot-y", ChartView)
    await until(pilot, lambda: view.chart is not None)
    app.screen.query_one(RunsTable).focus()
    await pilot.press("x")
    # Without a run the live curve is drawn.
    await until_shown(pilot, "Run keeps it")
    assert view.chart is not None
    assert [trace.name for trace in view.chart.traces] == ["live"]
    await pilot.press("ctrl+z")
    await until(pilot, lambda: runs.displayed is first)
    assert runs.baseline is first
    await pilot.press("f3")
    assert pilot.app.focused is pilot.app.screen.query_one("#row-mu").query_one(Input)

    file_result = simulate(t_end=20.0, samples=[0.01 * n for n in range(2001)])
    save_trajectory(file_result, tmp_path / "cli.npz")
    await pilot.press("alt+o")
    await until_shown(pilot, "Read a result")
    await answer(pilot, "cli.npz")
    await until_notice(pilot, "run 3 read from cli.npz")
    await until_shown(pilot, "3 on file")
    assert runs.displayed is first
    (tmp_path / "bad.csv").write_text("t,y\n0,0\n")
    await pilot.press("alt+o")
    await until_shown(pilot, "Read a result")
    await answer(pilot, "bad.csv")
    await until_notice(pilot, "bad.csv: not a trajectory: no column x")


async def test_the_engine_is_switched_and_two_engines_are_compared(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Replaces the FMU by a run with a visible error; other tests compare the FMU itself.
    def integrate_coarsely(request: Request, **_options: object) -> Transient:
        coarse_run = integrate(dataclasses.replace(request, method="taylor", tol=1e-6))
        return dataclasses.replace(coarse_run, method="fmu")

    monkeypatch.setattr("fivtui.fmu.integrate_fmu", integrate_coarsely)
    app = app_of(pilot)
    runs = app.session.runs
    await pilot.press("f4")
    await until_notice(pilot, "engine Python FMU: method fmu")
    await pilot.press("f9")
    await until(pilot, lambda: runs.baseline is not None)
    native, fmu = runs
    assert (native.engine, fmu.engine) == ("native", "Python FMU")
    assert runs.baseline is native
    assert runs.plotted == [native, fmu]
    await until_notice(pilot, "Python FMU against taylor: final state")
    await until_hidden(pilot, "inputs changed")
    await until_shown(pilot, "■ 2 shown Python FMU 10.50")
    await pilot.press("f4")
    await until_notice(pilot, "engine native FMU: method fmu-native")
    await pilot.press("f4")
    await until_notice(pilot, "engine native: method taylor")


async def test_keys_are_handled_during_a_run_and_stop_it(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    last_answers = []

    def compute_until_stopped(*_: object, progress: object, **__: object) -> None:
        while may_continue := progress(0.5):  # type: ignore[operator]
            sum(range(1000))
        last_answers.append(may_continue)
        raise Cancelled

    monkeypatch.setattr("fivtui.scene.run.compute", compute_until_stopped)
    runs = app_of(pilot).session.runs
    editor = await focus(pilot, "F")
    await pilot.press("f5")
    await until(pilot, lambda: runs.active is not None)
    await pilot.press("up", "up")
    assert editor.value == "82"
    await pilot.press("f5")
    # The run shows as stopped at once; its thread ends at its next progress callback.
    assert runs.active is None
    await until(pilot, lambda: last_answers == [False])


async def test_the_session_is_restored_at_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session_path = tmp_path / "state" / "session.json"
    app = FivtuiApp(state=session_path)
    async with app.run_test(size=SIZE) as pilot:
        await type_into(pilot, "F", "-")
        await type_into(pilot, "mu", "0.3")
        await pilot.press("alt+minus")
        app.theme = "gruvbox"
        # The session is also stored while the program runs.
        await until(
            pilot, lambda: session_path.is_file() and '"gruvbox"' in session_path.read_text()
        )
        await type_into(pilot, "F", "91")
        await pilot.press("ctrl+s")
        await until_shown(pilot, "Save the scene as")
        await answer(pilot, "mine.toml")
        await until_notice(pilot, f"scene mine saved: mine.toml in {tmp_path}")
        await focus(pilot, "k1")
        await pilot.press("up")
    second_app = FivtuiApp(state=session_path)
    assert second_app.theme == "gruvbox"
    async with second_app.run_test(size=SIZE) as pilot:
        await until_shown(pilot, "mine (changed)")
        texts = second_app.session.texts
        assert (texts["F"], texts["mu"], texts["k1"]) == ("91", "0.3", "110")
        await until(pilot, lambda: second_app.session.tab == "log")
        # Saving to the scene's own file asks no question unless another program changed it.
        await pilot.press("ctrl+s")
        await until_notice(pilot, f"scene mine saved: mine.toml in {tmp_path}")
        await until_hidden(pilot, "(changed)")
        # A scene that was read from a file of another suffix is not written there.
        second_app.session.record_saved(second_app.session.loaded, str(tmp_path / "mine.txt"))
        await pilot.press("ctrl+s")
        await until_shown(pilot, "Save the scene as")
        assert second_app.screen.query_one("#path", Input).value == "mine.toml"
        await pilot.press("escape")
        second_app.session.record_saved(second_app.session.loaded, str(tmp_path / "mine.toml"))
        scene_text = (tmp_path / "mine.toml").read_text()
        (tmp_path / "mine.toml").write_text(scene_text.replace("F = 91.0", "F = 92.0"))
        await pilot.press("ctrl+s")
        await until_shown(pilot, "Save the scene as")
        await pilot.press("enter")
        await until_shown(pilot, "Overwrite it?")
        await pilot.press("escape")
        assert "F = 92.0" in (tmp_path / "mine.toml").read_text()
        await pilot.press("ctrl+p")
        await until_shown(pilot, "Run the scene and keep the run")
        await pilot.press(*"recent")
        await until_shown(pilot, "Recent: ")
        await pilot.press("enter")
        await until(pilot, lambda: second_app.session.texts["F"] == "92")


async def test_a_damaged_session_is_renamed_and_a_scene_argument_keeps_the_stored_one(
    tmp_path: Path,
) -> None:
    session_path = tmp_path / "session.json"
    session_path.write_text("{")
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await until_notice(pilot, "the last session could not be restored (damaged)")
        assert (tmp_path / "session.unread-1.json").read_text() == "{"
        await until_shown(pilot, "UNSTABLE")
    data = json.loads(session_path.read_text())
    recent = [str(tmp_path / "old.toml")]
    session_path.write_text(json.dumps({**data, "recent": recent, "tab": "log"}))
    second_app = FivtuiApp(PRESETS["linear"], "linear", state=session_path)
    assert second_app.session.name == "linear"
    assert second_app.session.recent == (str(tmp_path / "old.toml"),)
    assert json.loads(session_path.read_text())["edits"]["loaded"]["name"] == "base"

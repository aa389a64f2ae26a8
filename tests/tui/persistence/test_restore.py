"""A restart restores runs, studies, settings and limits, and renames damaged files."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import DataTable, Input

from fivtui.maps import stability_map
from fivtui.model.errors import InputError
from fivtui.paper.claims.check import claims
from fivtui.results.tables import save_result
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.sweeps import Sweep, compute_rows
from fivtui.tradeoffs import measure as tradeoff
from fivtui.transient.files import restore_transient, store_transient
from fivtui.tui.app import FivtuiApp
from fivtui.tui.persistence import results as result_store
from fivtui.tui.persistence.results import ResultStore
from fivtui.tui.session.runs import RunState
from fivtui.tui.session.session import DisplayedStudy, StoredResult
from fivtui.tui.tabs.messages import RunActionRequested
from fivtui.tui.tabs.studies.sweep import SweepPane
from tests.support.laboratory import (
    app_of,
    chart_of,
    clear_notices,
    click_view,
    lab_of,
    run_to_end,
    show_tab,
    text_of,
    type_into,
    until,
    until_notice,
    until_screen,
    until_shown,
    until_still,
)

SIZE = (100, 40)
BASE = PRESETS["base"]


# Ends of scroll bars depend on whether Textual lays them out before a neighbour is hidden.
SCROLL_BAR_ENDS = dict.fromkeys(map(ord, "▏▎▍▌▋▊▉"), " ")


async def until_screen_equals(pilot: Pilot[None], screen: str) -> None:
    expected = screen.translate(SCROLL_BAR_ENDS)
    await until_screen(pilot, lambda text: text.translate(SCROLL_BAR_ENDS) == expected)


async def show_settled_tab(pilot: Pilot[None], tab: str, phrase: str) -> str:
    """Show a tab without notices and return the text of the screen."""
    await clear_notices(pilot)
    await show_tab(pilot, TAB_KEYS[tab])
    await until_shown(pilot, phrase)
    pilot.app.screen.query_one("#row-mu").query_one(Input).focus()
    await until_still(pilot)
    return text_of(pilot)


TAB_KEYS = {"transient": "alt+1", "sweep": "alt+6", "map": "alt+3", "trade-off": "alt+8"}
TAB_PHRASES = {
    "transient": "2nd half",
    "sweep": "8 transients",
    "map": "35 points",
    "trade-off": "taylor (compiled) tol=",
}


async def test_the_previous_screen_is_restored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Measure errors and times of the methods for 0.2 s of CPU time in place of 7 s.
    monkeypatch.setattr(tradeoff, "QUICK_S", 0.2)
    session_path = tmp_path / "session.json"
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        session = app_of(pilot).session
        await pilot.pause()
        await type_into(pilot, "t_end", "20")
        await run_to_end(pilot)
        await type_into(pilot, "F", "60")
        await run_to_end(pilot)
        (first, second) = session.runs
        for action in ("overlay", "colour", "baseline"):
            pilot.app.screen.post_message(RunActionRequested(1, action))
        await until(pilot, lambda: session.runs.baseline is first)
        chart_view = chart_of(pilot, "plot-y")
        chart_view.focus()
        # Zoom, pan, take a logarithmic y axis, and hide curve 2.
        await pilot.press("plus", "right", "y", "2")
        await show_tab(pilot, "alt+6")
        pilot.app.screen.query_one("#sweep-input", Input).value = "mu=0.2:0.8:4"
        await pilot.press("f10")
        await until_shown(pilot, TAB_PHRASES["sweep"])
        chart_of(pilot, "sweep-chart").focus()
        await pilot.press("3", "plus")
        await show_tab(pilot, "alt+3")
        # By default 121 values of μ times 93 of F.
        await until_shown(pilot, "11253 points")
        await click_view(pilot, "critical-mu")
        editor = pilot.app.screen.query_one("#map-input", Input)
        editor.value = "c1=0.1:1.5:7 k_nl=1:500:5"
        editor.focus()
        await pilot.press("enter")
        await until_shown(pilot, TAB_PHRASES["map"])
        await show_tab(pilot, "alt+8")
        await pilot.press("f10")
        await until_shown(pilot, TAB_PHRASES["trade-off"])
        await click_view(pilot, "peak")
        chart_of(pilot, "errors-chart").focus()
        await pilot.press("x")
        await show_tab(pilot, "alt+1")
        await pilot.pause()
        texts_before = {
            name: await show_settled_tab(pilot, name, phrase)
            for name, phrase in TAB_PHRASES.items()
        }
        await show_settled_tab(pilot, "map", TAB_PHRASES["map"])
        result = second.result
    folder = tmp_path / "results"
    # Two runs, the sweep and the trade-off; a map is computed again.
    assert len(list(folder.iterdir())) == 4

    monkeypatch.setattr(
        "fivtui.tui.tabs.studies.tradeoff.measure_tradeoff",
        lambda *_, **__: pytest.fail("measured"),
    )
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        session = app_of(pilot).session
        await until(pilot, lambda: not session.unread_results)
        assert session.tab == "map"
        for name, phrase in TAB_PHRASES.items():
            await show_settled_tab(pilot, name, phrase)
            await until_screen_equals(pilot, texts_before[name])
        (first, second) = session.runs
        assert session.runs.baseline is first
        assert first.overlaid
        assert second.result is not None
        assert result is not None
        assert second.result.stats == result.stats
        # New runs continue the numbering, and the stored files stay unchanged.
        file_names = {path.name for path in folder.iterdir()}
        await run_to_end(pilot)
        assert [run.number for run in session.runs] == [1, 2, 3]
        await show_tab(pilot, "alt+6")
    assert file_names <= {path.name for path in folder.iterdir()}
    assert len(list(folder.iterdir())) == 5


async def test_read_results_and_paper_figures_are_restored_and_incomplete_studies_reported(
    tmp_path: Path,
) -> None:
    session_path = tmp_path / "session.json"
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await pilot.pause()
        session = app_of(pilot).session
        study = SweepPane.parse(BASE, "F=10:20:30")
        incomplete_sweep = Sweep(study, compute_rows(study, 0, 4))
        session.studies["sweep"] = DisplayedStudy(incomplete_sweep, "base")
        lab = lab_of(pilot)
        lab.show_study("map", displayed_map())
        await until_shown(pilot, "read from mine.csv")
        await show_tab(pilot, "alt+0")
        await until_shown(pilot, "what it shows")
        pilot.app.screen.query_one("#figures").focus()
        await pilot.press("enter")
        await until_shown(pilot, "figure 2a computed")
        chart_of(pilot, "figure-1").focus()
        await pilot.press("plus", "1")
        pilot.app.screen.query_one("#row-mu").query_one(Input).focus()
        await clear_notices(pilot)
        await until_still(pilot)
        text_before = text_of(pilot)
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await until_notice(pilot, "sweep was not saved: it is incomplete")
        await until_shown(pilot, "figure 2a computed")
        await clear_notices(pilot)
        await until_screen_equals(pilot, text_before)
        await show_tab(pilot, "alt+3")
        await until_shown(pilot, "read from mine.csv")
        restored_map, original_map = app_of(pilot).session.studies.get("map"), displayed_map()
        assert restored_map is not None
        np.testing.assert_array_equal(restored_map.value.values, original_map.value.values)


async def test_a_damaged_result_stays_and_all_others_are_restored(
    tmp_path: Path,
) -> None:
    session_path = tmp_path / "session.json"
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await pilot.pause()
        await type_into(pilot, "t_end", "5")
        await run_to_end(pilot)
        await run_to_end(pilot)
    first_file, second_file = (
        tmp_path / "results" / entry["file"]
        for entry in json.loads(session_path.read_text())["results"].values()
    )
    first_file.write_bytes(first_file.read_bytes()[:100])
    app = FivtuiApp(PRESETS["linear"], "linear", state=session_path)
    async with app.run_test(size=SIZE) as pilot:
        await until_notice(pilot, "the run 1 of the last session could not be restored")
        first_run, second_run = app_of(pilot).session.runs
        assert (first_run.state, second_run.state) == (RunState.NOT_KEPT, RunState.DONE)
        await until_shown(pilot, "not kept")
        # A scene on the command line replaces the edited scene only.
        assert app_of(pilot).session.name == "linear"
        assert app_of(pilot).session.undo()
        assert app_of(pilot).session.texts["t_end"] == "5"
    assert first_file.is_file()
    assert second_file.is_file()


def test_a_stored_run_is_restored_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    for method, step in (("taylor", None), ("rk4", 0.01)):
        run = simulate(t_end=5.0, method=method, step=step, samples=np.linspace(0.0, 5.0, 501))
        store_transient(run, path)
        restored_run = restore_transient(path)
        for field in dataclasses.fields(run):
            restored_value, original_value = (
                getattr(restored_run, field.name),
                getattr(run, field.name),
            )
            # `changes` are the changes of mode on a belt of finite speed.
            if field.name in ("switch_times", "changes"):
                np.testing.assert_array_equal(restored_value, original_value)
            elif field.name == "trajectory":
                for name in ("t", "x", "vx", "y", "vy", "P", "mode"):
                    np.testing.assert_array_equal(
                        getattr(restored_value, name), getattr(original_value, name)
                    )
            else:
                assert restored_value == original_value
    path.write_bytes(b"PK")
    with pytest.raises(InputError, match=r"a\.npz: damaged"):
        restore_transient(path)


def displayed_map() -> DisplayedStudy[Any]:
    over = {"mu": np.linspace(0.0, 1.0, 3), "F": np.linspace(10.0, 20.0, 4)}
    return DisplayedStudy(stability_map(BASE.parameters, over), "mine", "mine.csv")


def test_results_are_written_once_and_removed_when_unused(tmp_path: Path) -> None:
    store, study = ResultStore(tmp_path), displayed_map()
    files, notes = store.save({"map": study})
    assert not notes
    path = tmp_path / files["map"].file
    write_time = path.stat().st_mtime_ns
    assert store.save({"map": study}) == (files, {})
    assert path.stat().st_mtime_ns == write_time
    # Without the map, its file is removed; undo may bring a result back.
    store.remove_unused({})
    assert not path.exists()
    new_files, _ = store.save({"map": study})
    second_store = ResultStore(tmp_path)
    second_store.adopt_files(new_files)
    restored_study = second_store.read(new_files)[0]["map"]
    assert (restored_study.name, restored_study.source) == ("mine", "mine.csv")
    np.testing.assert_array_equal(restored_study.value.values, study.value.values)
    # Results that were not read yet keep their files.
    assert second_store.save({"map": new_files["map"]}) == (new_files, {})
    # Files of other sessions and unknown files stay.
    other_files, _ = ResultStore(tmp_path).save({"map": displayed_map()})
    (tmp_path / "mine.txt").write_text("mine")
    newest_files, _ = second_store.save({"map": displayed_map()})
    second_store.remove_unused(newest_files)
    expected_names = {"mine.txt", other_files["map"].file, newest_files["map"].file}
    assert {file.name for file in tmp_path.iterdir()} == expected_names


def test_a_study_that_cannot_be_stored_keeps_the_previous_result(tmp_path: Path) -> None:
    store, study = ResultStore(tmp_path), SweepPane.parse(BASE, "F=10:20:30")
    complete_study = DisplayedStudy(Sweep(study, compute_rows(study, 0, study.members)), "base")
    partial_study = DisplayedStudy(Sweep(study, compute_rows(study, 0, 4)), "base")
    files, _ = store.save({"sweep": complete_study})
    store.remove_unused(files)
    new_files, notes = store.save({"sweep": partial_study})
    store.remove_unused(new_files)
    assert new_files == files
    assert notes == {"sweep": "it is incomplete; the previous result is kept"}
    restored_study = ResultStore(tmp_path).read(new_files)[0]["sweep"]
    assert restored_study.value.table.members == study.members


def test_too_large_results_give_a_note_and_files_outside_the_folder_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(result_store, "_MAX_SIZE", 100)
    store = ResultStore(tmp_path / "results")
    files, notes = store.save({"map": displayed_map()})
    assert not files
    assert "it takes" in notes["map"]
    save_result(displayed_map().value, tmp_path / "mine.npz")
    path = tmp_path / "results" / "mine.npz"
    results, (error,) = store.read({"map": StoredResult("../mine.npz")})
    assert results == {"map": None}
    message = "the map of the last session could not be restored"
    assert error == f"{message}: {path}: there is no such file"
    assert (tmp_path / "mine.npz").is_file()
    # An adopted file is removed when unused, but not outside the folder.
    store.adopt_files({"map": StoredResult("../mine.npz")})
    store.remove_unused({})
    assert (tmp_path / "mine.npz").is_file()


async def test_verdicts_on_claims_of_the_paper_are_restored(tmp_path: Path) -> None:
    session_path = tmp_path / "session.json"
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        verdicts = claims(["critical-friction-of-the-example"])
        app_of(pilot).session.studies["claims"] = DisplayedStudy(verdicts, "claims")
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await show_tab(pilot, "alt+0")
        await until_shown(pilot, "1 claims: does not hold 1")
        pilot.app.screen.query_one("#figures").focus()
        await pilot.press("v")
        await until_shown(pilot, "verdict section statement")
        table = pilot.app.screen.query_one("#claims-table", DataTable)
        assert table.get_row(verdicts[0].claim.id)[0] == "does not hold"

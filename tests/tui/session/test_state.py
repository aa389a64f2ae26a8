"""Undo, engines, baseline and stored state of a session, without a screen."""

import dataclasses
import json
import stat
from pathlib import Path

import numpy as np
import pytest

from fivtui.charts import Axis, View
from fivtui.distributions import parse_distribution
from fivtui.model.errors import InputError
from fivtui.model.parameters import Parameters
from fivtui.paper import PANELS
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.transient.files import save_trajectory
from fivtui.tui.lab.file_actions import load_run
from fivtui.tui.persistence.autosave import Autosave
from fivtui.tui.persistence.state_file import (
    STATE_VERSION,
    State,
    load_session,
    save_state,
    session_state,
    user_files,
)
from fivtui.tui.session.comparison import change_rows, engine_difference_text, percent_text
from fivtui.tui.session.jobs import Outcome
from fivtui.tui.session.runs import MAX_RUNS, Run, Runs, RunState, execute
from fivtui.tui.session.scene_differences import base_scene
from fivtui.tui.session.session import MAX_RECENT, Session
from fivtui.tui.tabs.paper import panel_scene

SHORT = dataclasses.replace(base_scene(), t_end=10.0)


def finish_run(runs: Runs, **values: object) -> Run:
    run = runs.start(SHORT.with_values(values))
    assert runs.finish(run, execute(run))
    return run


# Undo and redo


def test_typing_and_steps_in_one_direction_are_one_undo_step() -> None:
    session = Session()
    for text in ("9", "91", "91.5"):
        session.set_text("F", text)
    for _ in range(3):
        session.step_field("mu", 1)
    session.step_field("mu", -1)
    assert (session.texts["F"], session.texts["mu"]) == ("91.5", "0.72")
    assert session.undo()
    assert session.texts["mu"] == "0.73"
    assert session.undo()
    assert session.texts["mu"] == "0.7"
    assert session.undo()
    assert session.texts["F"] == "80"
    assert not session.undo()
    assert not session.changed_fields
    for _ in range(3):
        assert session.redo()
    assert (session.texts["F"], session.texts["mu"]) == ("91.5", "0.72")
    assert not session.redo()


def test_a_closed_step_is_undone_alone() -> None:
    session = Session()
    session.set_text("F", "90")
    session.close_undo_step()
    session.set_text("F", "95")
    session.undo()
    assert session.texts["F"] == "90"


def test_an_edit_after_undo_clears_redo() -> None:
    session = Session()
    session.set_text("F", "90")
    session.undo()
    session.set_text("k1", "7")
    assert not session.redo_steps
    session.undo()
    assert not session.changed_fields


def test_loading_and_resetting_are_undone_with_all_edits() -> None:
    session = Session()
    session.set_text("F", "x")
    session.load(PRESETS["stiff-contact"], "stiff-contact")
    assert session.name == "stiff-contact"
    session.set_text("mu", "1")
    session.reset_all()
    assert not session.changed_fields
    session.undo()
    assert session.texts["mu"] == "1"
    session.undo()
    session.undo()
    assert (session.name, session.source, session.texts["F"]) == ("base", "", "x")


def test_undo_continues_beyond_a_save_and_keeps_the_file() -> None:
    session = Session()
    session.set_text("F", "90")
    session.record_saved(dataclasses.replace(session.scene(), name="mine"), "mine.toml")
    assert not session.changed_fields
    session.undo()
    assert (session.name, session.source, session.changed_fields) == ("mine", "mine.toml", ["F"])
    session.redo()
    assert not session.changed_fields


# Engines


def test_the_engine_is_switched_to_either_fmu_and_back_to_the_previous_method() -> None:
    session = Session()
    session.set_text("method", "scipy-dop853")
    for engine, method in (("Python FMU", "fmu"), ("native FMU", "fmu-native")):
        session.switch_engine()
        assert (session.engine, session.texts["method"]) == (engine, method)
        solver, fmu = session.engine_pair()
        assert (solver.method, fmu.method) == ("scipy-dop853", method)
    session.switch_engine()
    assert (session.engine, session.texts["method"]) == ("native", "scipy-dop853")
    # The engine pair contains the last selected FMU.
    assert session.engine_pair()[1].method == "fmu-native"


def test_a_pair_of_engines_keeps_the_step_only_for_methods_with_a_step() -> None:
    session = Session()
    session.set_text("method", "rk4")
    session.set_text("step", "0.01")
    assert [scene.step for scene in session.engine_pair()] == [0.01, None]
    session.set_text("method", "fmu")
    assert [scene.step for scene in session.engine_pair()] == [None, None]


def test_the_difference_of_engines_is_reported_with_its_size() -> None:
    exact_run = simulate(t_end=10.0, samples=[0.0, 5.0, 10.0])
    coarse_run = simulate(t_end=10.0, samples=[0.0, 5.0, 10.0], method="rk4", step=0.01)
    assert "final state 0 (m, m/s), peak |y| 0 m" in engine_difference_text(exact_run, exact_run)
    text = engine_difference_text(exact_run, coarse_run)
    state_difference = max(
        abs(getattr(exact_run.final, name) - getattr(coarse_run.final, name))
        for name in ("x", "vx", "y", "vy")
    )
    assert f"final state {state_difference:.2g}" in text
    assert text.endswith("separations equal")


# Runs


def test_the_baseline_is_compared_by_difference_and_percent() -> None:
    runs = Runs()
    base, second = finish_run(runs), finish_run(runs, F=100.0)
    assert base.result is not None
    assert second.result is not None
    peak, base_peak = second.result.peak.y_abs, base.result.peak.y_abs
    percent = f"{100.0 * (peak - base_peak) / base_peak:+.3g}"
    assert percent_text(peak, base_peak) == percent
    assert (percent_text(peak, peak), percent_text(peak, 0.0)) == ("0", "–")
    row = change_rows(second.result, base.result)[0]
    assert row.label == "peak |y|"
    assert row.value[0] == percent[0]
    assert row.note.endswith(f"({percent} %)")
    assert change_rows(base.result, base.result)[0][1:] == ("0 m", f"from {base_peak:#.4g} m")


def test_the_displayed_run_is_drawn_last() -> None:
    runs = Runs()
    first, second, third = (finish_run(runs) for _ in range(3))
    runs.displayed = second
    assert runs.plotted == [second]
    first.overlaid = third.overlaid = True
    assert runs.plotted == [first, third, second]
    runs.remove(second)
    assert runs.displayed is third
    assert runs.plotted == [first, third]
    runs.baseline = first
    runs.remove(first)
    assert runs.baseline is None


def test_old_runs_are_deleted_except_the_displayed_one_and_the_baseline() -> None:
    runs = Runs()
    base, displayed = finish_run(runs), finish_run(runs)
    runs.baseline, runs.displayed = base, displayed
    for _ in range(MAX_RUNS):
        runs.finish(runs.start(SHORT), Outcome(error="not computed"))
    assert len(list(runs)) == MAX_RUNS
    assert list(runs)[:2] == [base, displayed]


def test_runs_without_results_are_deleted_first() -> None:
    runs = Runs()
    first, second, displayed = (finish_run(runs) for _ in range(3))
    runs.displayed = displayed
    stopped_runs = [runs.start(SHORT) for _ in range(MAX_RUNS - 3)]
    running = runs.start(SHORT)
    # One run more than MAX_RUNS: the oldest without a result is deleted.
    assert list(runs) == [first, second, displayed, *stopped_runs[1:], running]
    result = displayed.result
    assert result is not None
    loaded_runs = [runs.add_loaded(SHORT, result, "a.csv") for _ in stopped_runs]
    assert list(runs) == [second, displayed, running, *loaded_runs]


def test_a_deletion_is_redone_after_a_full_list_has_dropped_the_run() -> None:
    session = Session()
    run = session.runs.start(SHORT)
    session.runs.finish(run, Outcome(error="not computed"))
    session.delete_run(run)
    assert session.undo()
    for _ in range(MAX_RUNS):
        session.runs.finish(session.runs.start(SHORT), Outcome(error="not computed"))
    runs = list(session.runs)
    assert run not in runs
    assert session.redo()
    assert list(session.runs) == runs


def test_a_run_from_a_file_does_not_stop_the_active_run() -> None:
    runs = Runs()
    running = runs.start(SHORT)
    result = simulate(t_end=1.0, samples=[0.0, 1.0])
    loaded_run = runs.add_loaded(SHORT, result, "a.csv")
    assert runs.active is running
    assert runs.displayed is loaded_run
    assert (loaded_run.engine, loaded_run.number) == ("file", 2)
    runs.remove(running)
    assert runs.active is None
    assert not running.report(0.5)


# Runs from files


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
@pytest.mark.parametrize("separation", [True, False])
def test_a_run_is_read_from_its_file_as_it_was_written(
    suffix: str, separation: bool, tmp_path: Path
) -> None:
    scene = SHORT.with_values({"F": 90.0})
    written_run = simulate(
        scene.parameters, t_end=10.0, separation=separation, samples=np.linspace(0.0, 10.0, 5001)
    )
    path = tmp_path / f"mine{suffix}"
    save_trajectory(written_run, path)
    read_scene, read_run = load_run(path)
    assert read_scene.name == "mine"
    assert read_scene.parameters == scene.parameters == read_run.parameters
    assert (read_scene.separation, read_scene.t_end) == (separation, 10.0)
    assert read_scene.start == written_run.start
    assert read_run.peak.y_abs == pytest.approx(written_run.peak.y_abs, rel=1e-3)
    assert read_run.steady.y_half_range == pytest.approx(written_run.steady.y_half_range, rel=1e-3)
    assert read_run.final == written_run.final
    assert read_run.events.separations == written_run.events.separations
    assert read_run.events.reattachments == written_run.events.reattachments
    np.testing.assert_allclose(read_run.switch_times, written_run.switch_times, atol=1e-4)
    assert read_run.events.separated_time == pytest.approx(
        written_run.events.separated_time, abs=1e-3
    )
    assert read_run.trajectory is not None
    assert written_run.trajectory is not None
    np.testing.assert_array_equal(read_run.trajectory.y, written_run.trajectory.y)


def test_a_file_without_its_scene_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "foreign.csv"
    path.write_text("t,x,vx,y,vy,P,mode\n0,0,0,0,0,0,1\n1,0,0,0,0,0,1\n")
    with pytest.raises(InputError, match=r"foreign\.csv: has no settings of a run"):
        load_run(path)
    path.write_text(f"# parameters: [1]\n{path.read_text()}")
    with pytest.raises(InputError, match="has no settings of a run"):
        load_run(path)


# Scenes of figures


def test_every_figure_has_an_initial_scene() -> None:
    scenes = {scene.name: scene for scene in map(panel_scene, PANELS.values())}
    numbers = {int(name.removeprefix("fig-").rstrip("ab")) for name in scenes}
    assert numbers == set(range(2, 17))
    assert scenes["fig-5"].parameters == Parameters(F=100.0, c1=0.8)
    assert scenes["fig-12"].separation
    assert scenes["fig-13"].parameters == Parameters(k_nl=20.0, mu=0.5)
    for scene in scenes.values():
        assert Session(scene).scene() == scene


# Sessions between two starts


def state_of(session: Session) -> State:
    session.theme = "nord"
    return session_state(session)


def loaded_state(path: Path) -> State:
    session = load_session(path)
    assert session is not None
    return session_state(session)


def test_a_stored_session_is_restored_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    session = Session(PRESETS["stiff-contact"], "stiff-contact")
    session.set_text("F", "not yet a number")
    session.add_recent(str(tmp_path / "a.toml"))
    session.tab = "transient"
    session.runs.displayed = finish_run(session.runs)
    session.views["plot-y"] = View(Axis(1.0, 2.0), Axis(0.1, 9.0, log=True), log_y=True, hidden={1})
    save_state(state_of(session), {}, {}, path)
    (stored_view,) = json.loads(path.read_text())["views"].values()
    assert (stored_view["x"]["high"], stored_view["y"]["log"]) == (2.0, True)
    # The result of the run was not stored.
    session.runs.displayed.state = RunState.NOT_KEPT
    assert loaded_state(path).data == state_of(session).data
    assert load_session(tmp_path / "none.json") is None
    save_state(state_of(Session()), {}, {}, path)
    assert loaded_state(path) == state_of(Session())
    assert [file.name for file in path.parent.iterdir()] == ["session.json"]


def test_stored_paths_are_valid_in_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session(base_scene(), "mine.toml")
    session.add_recent("mine.toml")
    save_state(state_of(session), {}, {}, tmp_path / "session.json")
    restored = load_session(tmp_path / "session.json")
    assert restored is not None
    assert restored.source == restored.recent[0] == str(tmp_path / "mine.toml")
    session.add_recent(restored.recent[0])
    assert len(session.recent) == 1


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"{", "damaged"),
        (b"\xff\xfe", "damaged"),
        (b"[]", "damaged"),
        (json.dumps({"fivtui_session": STATE_VERSION}).encode(), "damaged"),
        (b'{"fivtui_session": 2}', "version 2, not 3"),
        (b'{"fivtui_session": 4}', "version 4, not 3"),
    ],
)
def test_an_unreadable_session_file_is_renamed(content: bytes, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    for number in (1, 2):
        path.write_bytes(content)
        autosave = Autosave(path)
        assert autosave.load() is None
        (notice,) = autosave.notices
        unread_path = tmp_path / f"session.unread-{number}.json"
        assert f"could not be restored ({reason}); it is kept as {unread_path}" in notice
        assert f"its results stay in {tmp_path / 'results'}" in notice
        assert unread_path.read_bytes() == content
        assert not path.exists()
        autosave.close(state_of(Session()))
        assert loaded_state(path) == state_of(Session())


def test_a_session_with_a_wrong_value_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    save_state(state_of(Session()), {}, {}, path)
    content = path.read_text()
    assert '"run_count": 0' in content
    path.write_text(content.replace('"run_count": 0', '"run_count": 1e999'))
    with pytest.raises(InputError, match="damaged"):
        load_session(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"x": []},
        {"x": {"low": 2.0, "high": 1.0}},
        {"x": {"low": 0.0, "high": float("inf")}},
        {"x": {"low": 0.0, "high": 1.0, "log": True}, "log_x": True},
        {"y": {"low": 1.0, "high": 2.0}, "log_y": True},
    ],
)
def test_only_an_invalid_view_of_a_session_is_dropped(
    changes: dict[str, object], tmp_path: Path
) -> None:
    path, session = tmp_path / "session.json", Session()
    session.views = {"plot-x": View(Axis(0.0, 1.0)), "plot-y": View(Axis(0.0, 1.0))}
    session.set_text("F", "90")
    save_state(state_of(session), {}, {}, path)
    data = json.loads(path.read_text())
    data["views"]["plot-y"] |= changes
    path.write_text(json.dumps(data))
    del session.views["plot-y"]
    assert loaded_state(path) == state_of(session)


def test_a_scene_with_scattered_parameters_is_restored(tmp_path: Path) -> None:
    path, scatter = tmp_path / "session.json", (("mu", parse_distribution("normal:0.4:0.04")),)
    session = Session(dataclasses.replace(base_scene(), scatter=scatter))
    save_state(state_of(session), {}, {}, path)
    assert loaded_state(path) == state_of(session)


def test_an_unknown_choice_of_a_session_is_replaced_by_that_of_its_scene(tmp_path: Path) -> None:
    path, session = tmp_path / "session.json", Session(PRESETS["linear"])
    save_state(state_of(session), {}, {}, path)
    data = json.loads(path.read_text())
    data["edits"]["texts"] |= {"method": "unknown", "F": "unknown"}
    path.write_text(json.dumps(data))
    restored = load_session(path)
    assert restored is not None
    assert restored.texts == session.texts | {"F": "unknown"}


def test_an_autosave_writes_only_changes_and_reports_errors(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    autosave = Autosave(path)
    session = Session()
    assert autosave.load() is None
    autosave.save(state_of(session))
    path.unlink()
    autosave.save(state_of(session))
    assert not path.exists()
    session.set_text("F", "1")
    path.mkdir()
    autosave.save(state_of(session))
    assert "is a folder" in autosave.save_error
    path.rmdir()
    session.set_text("F", "2")
    autosave.save(state_of(session))
    assert not autosave.save_error
    # Closing tries to write again.
    path.unlink()
    path.mkdir()
    session.set_text("F", "3")
    autosave.save(state_of(session))
    assert autosave.save_error
    path.rmdir()
    autosave.close(state_of(session))
    assert not autosave.save_error
    assert stat.S_ISREG(path.stat().st_mode)
    disabled_autosave = Autosave(None)
    disabled_autosave.save(state_of(session))
    assert disabled_autosave.load() is None


def test_recent_scenes_are_unique_and_limited() -> None:
    session = Session()
    for number in range(MAX_RECENT + 5):
        session.add_recent(f"{number}.toml")
    session.add_recent("10.toml")
    assert session.recent[0] == str(Path("10.toml").absolute())
    assert len(session.recent) == MAX_RECENT == len(set(session.recent))


def test_files_of_the_user_follow_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, f"/{name}")
    state, config = user_files()
    assert state == Path("/XDG_STATE_HOME/fivtui/session.json")
    assert config == Path("/XDG_CONFIG_HOME/fivtui/config.toml")
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    assert user_files()[0].is_relative_to(Path("~").expanduser())
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    with pytest.raises(InputError, match=r"home directory .* set an absolute HOME or XDG"):
        user_files()

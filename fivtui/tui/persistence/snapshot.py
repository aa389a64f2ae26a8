"""Converts between a session and its saved state. Imports no Textual."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Final

from fivtui.charts import Cursors
from fivtui.scene import scene_from_dict, scene_to_dict
from fivtui.tui.session import (
    SAFETY_MAPS,
    Run,
    RunState,
    RunStyle,
    Session,
    StoredResult,
    study_key,
)

from .state_file import SavedRun, SavedRuns, State

_RUN_PREFIX: Final = "run-"


def session_state(session: Session, theme: str) -> State:
    """The state to save: a copy of the session that shares its results."""
    runs = session.runs
    results: dict[str, object] = {}
    for run in runs:
        key = f"{_RUN_PREFIX}{run.number}"
        if run.result is not None:
            results[key] = run
        elif key in session.unread_results:
            results[key] = session.unread_results[key]
    # Results of studies that are displayed replace those that are not read yet.
    results |= {
        key: stored
        for key, stored in session.unread_results.items()
        if not key.startswith(_RUN_PREFIX)
    }
    results |= session.studies
    return State(
        session.edit_state,
        session.recent,
        session.tab,
        theme,
        settings={tab: dict(values) for tab, values in session.settings.items()},
        views={
            chart_id: dataclasses.replace(view, hidden=set(view.hidden), cursors=Cursors())
            for chart_id, view in session.views.items()
        },
        runs=SavedRuns(
            tuple(map(_saved_run, runs)),
            runs.count,
            0 if runs.displayed is None else runs.displayed.number,
            0 if runs.baseline is None else runs.baseline.number,
        ),
        results=results,
    )


def _saved_run(run: Run) -> SavedRun:
    # A run in progress will count as stopped. Runs that compare engines have an `edited_scene`,
    # that of the form: their `scene` may have another method.
    state = RunState.STOPPED if run.state is RunState.RUNNING else run.state
    return SavedRun(
        number=run.number,
        scene=scene_to_dict(run.scene),
        state=state,
        message=run.message,
        edited=None if run.edited_scene is None else scene_to_dict(run.edited_scene),
        source=run.source,
        overlaid=run.overlaid,
        colour=run.style.colour,
        marker=run.style.marker,
    )


def restore_session(session: Session, state: State) -> None:
    """Restore a session except the edited texts and the results."""
    session.recent = state.recent
    session.settings = {tab: dict(values) for tab, values in state.settings.items()}
    _restore_earlier_tabs(session)
    session.views = {
        chart_id: dataclasses.replace(view, hidden=set(view.hidden), cursors=Cursors())
        for chart_id, view in state.views.items()
    }
    session.unread_results = {
        key: stored for key, stored in state.results.items() if isinstance(stored, StoredResult)
    }
    runs = session.runs
    runs.restore((_restore_run(saved, state) for saved in state.runs.runs), state.runs.count)
    runs.displayed = runs.find(state.runs.shown)
    runs.baseline = runs.find(state.runs.baseline)


def _restore_earlier_tabs(session: Session) -> None:
    # The numbers of a run were a tab, and maps of safety were values of the tab of maps.
    if session.tab == "result":
        session.tab = "transient"
        session.settings.setdefault("transient", {})["view"] = "result"
    map_settings = session.settings.get("map", {})
    if map_settings.get("value") in SAFETY_MAPS:
        if session.tab == "map":
            session.tab = "safe-mu"
        session.settings.setdefault("safe-mu", {})["value"] = map_settings.pop("value")


def restore_results(session: Session, results: Mapping[str, Any]) -> None:
    """Add results read from files to a session; a result is None if it could not be read."""
    for key, result in results.items():
        session.unread_results.pop(key, None)
        if not key.startswith(_RUN_PREFIX):
            # Keep a newer result that was computed since the start.
            if result is not None:
                session.studies.setdefault(study_key(key, result.value), result)
            continue
        # A run that was deleted while its file was read may be restored by undo.
        run = session.runs.find_with_removed(int(key.removeprefix(_RUN_PREFIX)))
        if run is not None:
            run.result = result
            run.state = RunState.DONE if result is not None else RunState.NOT_KEPT


def _restore_run(saved: SavedRun, state: State) -> Run:
    run = Run(saved.number, scene_from_dict(saved.scene), saved.state, fraction=1.0)
    run.message, run.source = saved.message, saved.source
    run.edited_scene = None if saved.edited is None else scene_from_dict(saved.edited)
    run.overlaid = saved.overlaid
    run.style = RunStyle(saved.colour, saved.marker)
    if run.state is RunState.DONE and f"{_RUN_PREFIX}{run.number}" not in state.results:
        run.state = RunState.NOT_KEPT
    return run

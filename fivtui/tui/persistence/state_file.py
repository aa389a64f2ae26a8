"""The session file: a session as JSON. Imports no Textual."""

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from fivtui.charts import Axis, View
from fivtui.io import output_path, save_json
from fivtui.model import InputError
from fivtui.results import from_data, to_data
from fivtui.scene import (
    Scene,
    over_time_to_dict,
    parse_over_time,
    scene_from_dict,
    scene_to_dict,
)
from fivtui.studies import STUDIES
from fivtui.tui.session import (
    FIELDS,
    SAFETY_MAPS,
    EditState,
    Run,
    RunState,
    RunStyle,
    Session,
    SessionResult,
    StoredResult,
    study_key,
    study_kind,
)

# Version of the format, and its key in the file.
STATE_VERSION: Final = 2
_VERSION_KEY: Final = "fivtui_session"
_RUN_PREFIX: Final = "run-"
# Limit of the number appended to the name of a damaged file.
_MAX_DAMAGED: Final = 100


class DamagedSession(InputError):
    """The session file is damaged, or its version is too old."""


@dataclass(frozen=True, slots=True)
class State:
    """A copy of a session to be saved: the `data` of its file, and its results.

    The data contain scenes and tables over time, converted to JSON only when they are saved. Keys
    of results are such as ``run-1`` or ``sweep``.
    """

    data: dict[str, Any]
    results: Mapping[str, SessionResult]


def state_path(environment: Mapping[str, str] | None = None) -> Path:
    """The default session file.

    ``fivtui/session.json`` in XDG_STATE_HOME, in LOCALAPPDATA on Windows, or in ``~/.local/state``.
    """
    folder = user_folder("XDG_STATE_HOME", "LOCALAPPDATA", "~/.local/state", environment)
    return folder / "session.json"


def user_folder(
    name: str, windows_name: str, default: str, environment: Mapping[str, str] | None
) -> Path:
    """``fivtui`` in the folder that a variable names (another on Windows), or in `default`."""
    variables = os.environ if environment is None else environment
    folder = variables.get(name, "")
    if not Path(folder).is_absolute():
        windows_folder = variables.get(windows_name, "") if os.name == "nt" else ""
        try:
            folder = windows_folder or str(Path(default).expanduser())
        except RuntimeError:
            raise InputError(f"no home folder: set the variable HOME or {name}") from None
    return Path(folder) / "fivtui"


def session_state(session: Session) -> State:
    """The state to save: a copy of the session that shares its results."""
    runs = session.runs
    data = {
        _VERSION_KEY: STATE_VERSION,
        "texts": dict(session.texts),
        "scene": session.loaded,
        "over_time": session.over_time,
        "source": _absolute_source(session.source),
        "recent": [_absolute_source(recent) for recent in session.recent],
        "tab": session.tab,
        "theme": session.theme,
        "settings": {tab: dict(values) for tab, values in session.settings.items()},
        "views": {name: _view_to_dict(view) for name, view in session.views.items()},
        "runs": {
            "runs": list(map(_run_to_dict, runs)),
            "count": runs.count,
            "shown": 0 if runs.displayed is None else runs.displayed.number,
            "baseline": 0 if runs.baseline is None else runs.baseline.number,
        },
    }
    runs_by_key = {f"{_RUN_PREFIX}{run.number}": run for run in runs}
    results: dict[str, SessionResult] = {
        key: stored
        for key, stored in session.unread_results.items()
        if key in runs_by_key or not key.startswith(_RUN_PREFIX)
    }
    results |= {key: run for key, run in runs_by_key.items() if run.result is not None}
    # Results of studies that are displayed replace those that are not read yet.
    return State(data, results | session.studies)


def _run_to_dict(run: Run) -> dict[str, Any]:
    # A run in progress will count as stopped. Runs that compare engines have an `edited_scene`,
    # that of the form: their `scene` may have another method.
    return {
        "number": run.number,
        "scene": run.scene,
        "state": (RunState.STOPPED if run.state is RunState.RUNNING else run.state).value,
        "message": run.message,
        "edited": run.edited_scene,
        "source": run.source,
        "overlaid": run.overlaid,
        "colour": run.style.colour,
        "marker": run.style.marker,
    }


def _run_from_dict(data: Mapping[str, Any]) -> Run:
    scene, state = scene_from_dict(data["scene"]), RunState(data["state"])
    run = Run(int(data["number"]), scene, state, fraction=1.0)
    run.message, run.source = str(data["message"]), str(data["source"])
    run.edited_scene = None if data["edited"] is None else scene_from_dict(data["edited"])
    run.overlaid = bool(data["overlaid"])
    run.style = RunStyle(int(data["colour"]), int(data["marker"]))
    return run


def _view_to_dict(view: View) -> dict[str, Any]:
    return {
        "x": view.x and [view.x.low, view.x.high, view.x.log],
        "y": view.y and [view.y.low, view.y.high, view.y.log],
        "log_x": view.log_x,
        "log_y": view.log_y,
        # Indices of hidden traces.
        "hidden": sorted(view.hidden),
        # The heading of a chart warns of runs that are newer and outside the limits.
        "since": view.newest_run_when_zoomed,
    }


def _view_from_dict(data: Mapping[str, Any]) -> View:
    x, y = (_axis_from_data(data[name], bool(data[f"log_{name}"])) for name in ("x", "y"))
    hidden, newest_run = set(map(int, data["hidden"])), int(data.get("since", 0))
    log_x, log_y = bool(data["log_x"]), bool(data["log_y"])
    return View(x, y, log_x, log_y, hidden, newest_run_when_zoomed=newest_run)


def _axis_from_data(data: Any, log: bool) -> Axis | None:
    if data is None:
        return None
    axis = Axis(float(data[0]), float(data[1]), bool(data[2]))
    is_ordered = -math.inf < axis.low < axis.high < math.inf
    if not is_ordered or axis.log is not log or (axis.log and axis.low <= 0.0):
        raise InputError(f"invalid limits of an axis: {data}")
    return axis


def _absolute_source(source: str) -> str:
    # The next start may be in another folder. The name of a preset has no suffix.
    path = Path(source)
    return str(path.absolute()) if path.suffix else source


def save_state(
    state: State, files: Mapping[str, StoredResult], notes: Mapping[str, str], path: Path
) -> None:
    """Write a session file atomically; raises `InputError` if it cannot be written.

    `files` are the stored results by key, `notes` say why a result was not stored.
    """
    data = {**_to_json(state.data), "results": to_data(files), "notes": dict(notes)}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be made a folder: {error.strerror}") from None
    save_json(data, output_path(path, force=True))


def _to_json(value: Any) -> Any:
    # Tuples are tables over time.
    if isinstance(value, Scene):
        return scene_to_dict(value)
    if isinstance(value, tuple):
        return over_time_to_dict(value)
    if isinstance(value, dict):
        return {key: _to_json(item) for key, item in value.items()}
    return list(map(_to_json, value)) if isinstance(value, list) else value


def load_session(path: Path) -> Session | None:
    """Read a session without its results from a file; None if it does not exist.

    Raises `DamagedSession` if it is damaged or too old, `InputError` if unreadable or too new.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
    try:
        data = json.loads(content)
        version = data[_VERSION_KEY]
        if version == STATE_VERSION:
            return _session_from_dict(data)
    except InputError as error:
        raise DamagedSession(str(error)) from None
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError, OverflowError):
        raise DamagedSession("damaged") from None
    if isinstance(version, int) and version > STATE_VERSION:
        raise InputError(f"version {version}, written by a newer fivtui, not {STATE_VERSION}")
    raise DamagedSession(f"version {version!r}, not {STATE_VERSION}")


def _session_from_dict(data: Any) -> Session:
    session = Session(scene_from_dict(data["scene"]), str(data["source"]))
    texts = {
        name: str(text)
        for name, text in data["texts"].items()
        if name in FIELDS and text in (FIELDS[name].choices or {text})
    }
    over_time = session.over_time
    if "over_time" in data:
        over_time = parse_over_time("over_time", data["over_time"])
    edit_state = EditState(session.texts | texts, over_time, session.loaded, session.source)
    if edit_state != session.edit_state:
        # Undo leads to the scene without edits.
        session.restore(edit_state)
    session.recent = from_data(data["recent"], tuple[str, ...])
    session.tab, session.theme = str(data["tab"]), str(data["theme"])
    session.not_stored = from_data(data["notes"], dict[str, str])
    session.settings = from_data(data["settings"], dict[str, dict[str, str]])
    _rename_earlier_tabs(session)
    session.views = {name: _view_from_dict(view) for name, view in data["views"].items()}
    session.unread_results = {
        key: from_data(stored, StoredResult)
        for key, stored in data["results"].items()
        if re.fullmatch(rf"{_RUN_PREFIX}[1-9][0-9]*", key)
        or (study_kind(key) in STUDIES and key != "run")
    }
    runs = session.runs
    runs.restore(map(_run_from_dict, data["runs"]["runs"]), int(data["runs"]["count"]))
    for run in runs:
        if run.state is RunState.DONE and f"{_RUN_PREFIX}{run.number}" not in data["results"]:
            run.state = RunState.NOT_KEPT
    runs.displayed = runs.find(int(data["runs"]["shown"]))
    runs.baseline = runs.find(int(data["runs"]["baseline"]))
    return session


def _rename_earlier_tabs(session: Session) -> None:
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


def rename_damaged(path: Path) -> str:
    """Rename a damaged file. Returns a phrase that names its new path."""
    for number in range(1, _MAX_DAMAGED):
        new_path = path.with_name(f"{path.stem}.damaged-{number}{path.suffix}")
        if not new_path.exists():
            try:
                path.rename(new_path)
            except OSError:
                break
            return f"it is kept as {new_path}"
    return f"it stays in {path}"

"""The session file: a session as JSON, of one version only. Imports no Textual."""

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any, Final, TypedDict, get_type_hints

from platformdirs import user_config_path, user_state_path

from fivtui.charts import Cursors, View
from fivtui.io import output_path, save_bytes
from fivtui.model import InputError
from fivtui.results import from_data, to_data
from fivtui.studies import STUDIES
from fivtui.transient import Transient
from fivtui.tui.session import (
    FIELDS,
    SAFETY_MAPS,
    DisplayedStudy,
    EditState,
    Job,
    ResultKey,
    Run,
    Runs,
    RunState,
    Session,
    StoredResult,
)

# Version of the format, and its key in the file.
STATE_VERSION: Final = 3
_VERSION_KEY: Final = "fivtui_session"

# Types of the attributes of a run in the file: all but its result, and its progress as a job.
_UNSTORED: Final = {"result", "_parts", *get_type_hints(Job)}
_RUN_TYPES: Final = {n: kind for n, kind in get_type_hints(Run).items() if n not in _UNSTORED}

# The result of a run, a displayed study, or a result that is not read yet.
SessionResult = Transient | DisplayedStudy[Any] | StoredResult


@dataclass(frozen=True, slots=True)
class State:
    """A copy of a session to be saved: the `data` of its file, and its results.

    The data are converted to JSON only when they are saved. The key of a result is its run, or the
    key of a study such as ``sweep``.
    """

    data: dict[str, Any]
    results: Mapping[ResultKey, SessionResult]


class _SessionAttributes(TypedDict):
    # Attributes of a session.
    recent: tuple[str, ...]
    tab: str
    theme: str
    live_enabled: bool
    settings: dict[str, dict[str, str]]


class _StoredSession(_SessionAttributes):
    # The contents of a file. The shown run and the baseline are numbers, 0 for none.
    edits: EditState
    views: dict[str, Any]
    runs: list[dict[str, Any]]
    run_count: int
    shown: int
    baseline: int
    results: dict[str, StoredResult]
    not_stored: dict[str, str]


def user_files() -> tuple[Path, Path]:
    """The default session file and configuration file; `InputError` without a home folder."""
    try:
        state_folder = user_state_path("fivtui", appauthor=False)
        config_folder = user_config_path("fivtui", appauthor=False, roaming=True)
    except RuntimeError as error:
        raise InputError(str(error)) from None
    return state_folder / "session.json", config_folder / "config.toml"


def session_state(session: Session) -> State:
    """The state to save: a copy of the session that shares its results."""
    runs, path = session.runs, Path(session.source)
    # The next start may be in another folder. The name of a preset has no suffix.
    source = str(path.absolute()) if path.suffix else session.source
    data = {
        **{name: deepcopy(getattr(session, name)) for name in _SessionAttributes.__annotations__},
        "edits": replace(session.edit_state, source=source),
        # Without cursors, and without the size of the widget.
        "views": {
            name: replace(view, hidden=set(view.hidden), cursors=Cursors(), rows=0)
            for name, view in session.views.items()
        },
        "runs": list(map(_stored_run, runs)),
        "run_count": runs.count,
        "shown": 0 if runs.displayed is None else runs.displayed.number,
        "baseline": 0 if runs.baseline is None else runs.baseline.number,
    }
    results: dict[ResultKey, SessionResult] = {
        key: stored
        for key, stored in session.unread_results.items()
        if isinstance(key, str) or key in runs
    }
    results |= {run: run.result for run in runs if run.result is not None}
    # Results of studies that are displayed replace those that are not read yet.
    return State(data, results | session.studies)


def _stored_run(run: Run) -> dict[str, Any]:
    data = {name: getattr(run, name) for name in _RUN_TYPES}
    # A run in progress will count as stopped.
    return data | ({"state": RunState.STOPPED} if run.state is RunState.RUNNING else {})


def save_state(
    state: State,
    files: Mapping[ResultKey, StoredResult],
    reasons_not_stored: Mapping[ResultKey, str],
    path: Path,
) -> None:
    """Write a session file atomically; raises `InputError` if it cannot be written.

    `files` are the stored results by key.
    """
    data = {
        _VERSION_KEY: STATE_VERSION,
        **state.data,
        "results": {str(key): stored for key, stored in files.items()},
        "not_stored": {str(key): reason for key, reason in reasons_not_stored.items()},
    }
    # Numbers may be infinite: the bounds of a distribution that is not truncated.
    save_bytes(json.dumps(to_data(data), indent=2).encode(), output_path(path, force=True))


def load_session(path: Path) -> Session | None:
    """Read a session without its results from a file; None if it does not exist.

    Raises `InputError` if it cannot be read, is damaged, or is of another version.
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
            return _restored_session(from_data(data, _StoredSession))
    except (ValueError, LookupError, TypeError, RecursionError):
        raise InputError("damaged") from None
    raise InputError(f"version {version!r}, not {STATE_VERSION}")


def _restored_session(data: Mapping[str, Any]) -> Session:
    edits: EditState = data["edits"]
    session = Session(edits.loaded, edits.source)
    texts = {
        name: text
        for name, text in edits.texts.items()
        if name in FIELDS and text in (FIELDS[name].choices or {text})
    }
    edited = replace(edits, texts=session.texts | texts)
    if edited != session.edit_state:
        # Undo leads to the scene without edits.
        session.restore(edited)
    for name in _SessionAttributes.__annotations__:
        setattr(session, name, data[name])
    session.not_stored = data["not_stored"]
    for name, view in data["views"].items():
        with suppress(ValueError):
            session.views[name] = _restored_view(view)
    runs = Runs(map(_restored_run, data["runs"]), data["run_count"])
    runs.displayed, runs.baseline = runs.find(data["shown"]), runs.find(data["baseline"])
    session.runs, runs_by_key = runs, {str(run): run for run in runs}
    for key, run in runs_by_key.items():
        if run.state is RunState.DONE and key not in data["results"]:
            run.state = RunState.NOT_KEPT
    session.unread_results = {
        runs_by_key.get(key, key): stored
        for key, stored in data["results"].items()
        if key in {*runs_by_key, *STUDIES, *SAFETY_MAPS}
    }
    return session


def _restored_run(data: Mapping[str, Any]) -> Run:
    return Run(**{name: from_data(value, _RUN_TYPES[name]) for name, value in data.items()})


def _restored_view(data: Any) -> View:
    # Raises `ValueError` if a view is invalid, without which the rest of a session is restored.
    view: View = from_data(data, View)
    for axis, log in ((view.x, view.log_x), (view.y, view.log_y)):
        if axis is not None:
            is_ordered = (0.0 if log else -math.inf) < axis.low < axis.high < math.inf
            if not is_ordered or axis.log is not log:
                raise ValueError("invalid limits of an axis")
    return view


def restore_results(session: Session, results: Mapping[ResultKey, Any]) -> None:
    """Add results read from files to a session; a result is None if it could not be read."""
    for key, result in results.items():
        session.unread_results.pop(key, None)
        if isinstance(key, Run):
            # Undo may bring back a run that was deleted in the meantime.
            key.result = result
            key.state = RunState.NOT_KEPT if result is None else RunState.DONE
        elif result is not None:
            # Keep a newer result that was computed since the start.
            session.studies.setdefault(key, result)


def rename_unread(path: Path) -> str:
    """Rename a session file that cannot be read. Returns a phrase that names its new path."""
    paths = (path.with_name(f"{path.stem}.unread-{n}{path.suffix}") for n in count(1))
    new_path = next(candidate for candidate in paths if not candidate.exists())
    try:
        path.rename(new_path)
    except OSError:
        return f"it stays in {path}"
    return f"it is kept as {new_path}"

"""The session file: the state of a session as JSON. Imports no Textual."""

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fivtui.charts import Axis, View
from fivtui.io import output_path, save_json
from fivtui.model import InputError
from fivtui.results import from_data, to_data
from fivtui.scene import over_time_to_dict, parse_over_time, scene_from_dict, scene_to_dict
from fivtui.studies import STUDIES
from fivtui.tui.session import FIELDS, EditState, RunState, StoredResult, study_kind

# Version of the format, and its key in the file.
STATE_VERSION: Final = 2
_VERSION_KEY: Final = "fivtui_session"
# Limit of the number appended to the name of a damaged file.
_MAX_DAMAGED: Final = 100


class DamagedSession(InputError):
    """The session file is damaged, or its version is too old."""


@dataclass(frozen=True, slots=True)
class SavedRun:
    """A saved run without its result.

    Scenes are JSON data: `scene` was computed, `edited` was in the form if engines were compared.
    """

    number: int
    scene: dict[str, Any]
    state: RunState
    message: str
    edited: dict[str, Any] | None
    source: str
    overlaid: bool
    colour: int
    marker: int


@dataclass(frozen=True, slots=True)
class SavedRuns:
    """The saved runs, oldest first; `shown` and `baseline` are numbers of runs or 0."""

    runs: tuple[SavedRun, ...] = ()
    count: int = 0
    shown: int = 0
    baseline: int = 0


@dataclass(frozen=True, slots=True)
class State:
    """The saved state of a session.

    Attributes
    ----------
    edit_state : EditState
        The edited texts.
    recent : tuple of str
        Paths of recent scene files.
    tab, theme : str
        Names of the displayed tab and of the theme; unknown names are ignored.
    settings : mapping of str to mapping
        Stored settings, such as texts of inputs, by tab and key.
    views : mapping of str to View
        Visible parts of the charts by identifier, without cursors.
    runs : SavedRuns
        The runs.
    results : mapping of str to object
        Results by key, such as ``run-1`` or ``sweep``: `Run`, `DisplayedStudy`,
        or `StoredResult` if unread.
    notes : mapping of str to str
        By key, why a result was not stored.
    """

    edit_state: EditState
    recent: tuple[str, ...] = ()
    tab: str = ""
    theme: str = ""
    settings: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    views: Mapping[str, View] = field(default_factory=dict)
    runs: SavedRuns = field(default_factory=SavedRuns)
    results: Mapping[str, object] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)


def state_path(environment: Mapping[str, str] | None = None) -> Path:
    """The default session file.

    ``fivtui/session.json`` in XDG_STATE_HOME, in LOCALAPPDATA on Windows, or in ``~/.local/state``.
    """
    variables = os.environ if environment is None else environment
    folder = variables.get("XDG_STATE_HOME", "")
    if not Path(folder).is_absolute():
        app_data = variables.get("LOCALAPPDATA", "") if os.name == "nt" else ""
        folder = app_data or str(Path("~/.local/state").expanduser())
    return Path(folder) / "fivtui" / "session.json"


def save_state(state: State, path: Path) -> None:
    """Write a session file atomically; raises `InputError` if it cannot be written."""
    data = {
        _VERSION_KEY: STATE_VERSION,
        "texts": dict(state.edit_state.texts),
        "scene": scene_to_dict(state.edit_state.loaded),
        "over_time": over_time_to_dict(state.edit_state.over_time),
        "source": _absolute_source(state.edit_state.source),
        "recent": [_absolute_source(recent) for recent in state.recent],
        "tab": state.tab,
        "theme": state.theme,
        "settings": {name: dict(values) for name, values in state.settings.items()},
        "views": {name: _view_to_dict(view) for name, view in state.views.items()},
        "runs": to_data(state.runs),
        "results": {
            key: to_data(stored)
            for key, stored in state.results.items()
            if isinstance(stored, StoredResult)
        },
        "notes": dict(state.notes),
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be made a folder: {error.strerror}") from None
    save_json(data, output_path(path, force=True))


def _view_to_dict(view: View) -> dict[str, Any]:
    return {
        **{
            name: None if axis is None else [axis.low, axis.high, axis.log]
            for name, axis in (("x", view.x), ("y", view.y))
        },
        "log_x": view.log_x,
        "log_y": view.log_y,
        # Indices of hidden traces.
        "hidden": sorted(view.hidden),
        # The heading of a chart warns of runs that are newer and outside the limits.
        "since": view.newest_run_when_zoomed,
    }


def _view_from_dict(data: Mapping[str, Any]) -> View:
    x, y = (_axis_from_data(data[name], bool(data[f"log_{name}"])) for name in ("x", "y"))
    hidden = {int(trace_index) for trace_index in data["hidden"]}
    newest_run = int(data.get("since", 0))
    return View(
        x,
        y,
        bool(data["log_x"]),
        bool(data["log_y"]),
        hidden,
        newest_run_when_zoomed=newest_run,
    )


def _axis_from_data(data: Any, log: bool) -> Axis | None:
    if data is None:
        return None
    axis = Axis(float(data[0]), float(data[1]), bool(data[2]))
    is_ordered = math.isfinite(axis.low) and math.isfinite(axis.high) and axis.low < axis.high
    if not is_ordered or axis.log is not log or (axis.log and axis.low <= 0.0):
        raise InputError(f"invalid limits of an axis: {data}")
    return axis


def _absolute_source(source: str) -> str:
    # The next start may be in another folder. The name of a preset has no suffix.
    path = Path(source)
    return str(path.absolute()) if path.suffix else source


def load_state(path: Path) -> State | None:
    """Read a session file; None if it does not exist.

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
        state = _state_from_dict(data) if version == STATE_VERSION else None
    except InputError as error:
        raise DamagedSession(str(error)) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OverflowError):
        raise DamagedSession("damaged") from None
    if state is not None:
        return state
    if isinstance(version, int) and version > STATE_VERSION:
        raise InputError(f"version {version}, written by a newer fivtui, not {STATE_VERSION}")
    raise DamagedSession(f"version {version!r}, not {STATE_VERSION}")


def _state_from_dict(data: Any) -> State:
    loaded = scene_from_dict(data["scene"])
    texts = {name: field.text_of(loaded) for name, field in FIELDS.items()}
    texts |= {name: str(text) for name, text in data["texts"].items() if name in FIELDS}
    over_time = loaded.over_time
    if "over_time" in data:
        over_time = parse_over_time("over_time", data["over_time"])
    runs = from_data(data["runs"], SavedRuns)
    for run in runs.runs:
        # Raise an error for a damaged scene here.
        for scene in filter(None, (run.scene, run.edited)):
            scene_from_dict(scene)
    return State(
        edit_state=EditState(texts, over_time, loaded, str(data["source"])),
        recent=from_data(data["recent"], tuple[str, ...]),
        tab=from_data(data["tab"], str),
        theme=from_data(data["theme"], str),
        settings=from_data(data["settings"], dict[str, dict[str, str]]),
        views={name: _view_from_dict(view) for name, view in data["views"].items()},
        runs=runs,
        results={
            key: from_data(stored, StoredResult)
            for key, stored in data["results"].items()
            if re.fullmatch(r"run-[1-9][0-9]*", key)
            or (study_kind(key) in STUDIES and key != "run")
        },
        notes=from_data(data["notes"], dict[str, str]),
    )


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

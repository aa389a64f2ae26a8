"""The session between two starts: one small file. Imports no Textual."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

from fivtui.core.errors import InputError
from fivtui.files import write_atomically
from fivtui.scene import scene_from_dict, scene_to_dict

from .fields import FIELDS
from .history import Edited

STATE_VERSION: Final = 1
_VERSION_KEY: Final = "fivtui_session"
_ASIDE: Final = 100


@dataclass(frozen=True, slots=True)
class State:
    """What is kept between two starts.

    Attributes
    ----------
    edited : Edited
        What was being edited.
    recent : tuple of str
        See `Session`.
    tab : str
        The tab in sight; one that is not known is ignored.
    theme : str
        The theme; one that is not known is ignored.
    """

    edited: Edited
    recent: tuple[str, ...] = ()
    tab: str = ""
    theme: str = ""


def state_path(environment: Mapping[str, str] | None = None) -> Path:
    """Where the session is kept.

    Parameters
    ----------
    environment : mapping, optional
        Environment variables; those of the process if not given.

    Returns
    -------
    Path
        ``fivtui/session.json`` in XDG_STATE_HOME, in LOCALAPPDATA on Windows, or else in
        ``~/.local/state``.
    """
    known = os.environ if environment is None else environment
    home = known.get("XDG_STATE_HOME", "")
    if not Path(home).is_absolute():
        local = known.get("LOCALAPPDATA", "") if os.name == "nt" else ""
        home = local or str(Path("~/.local/state").expanduser())
    return Path(home) / "fivtui" / "session.json"


def save_state(state: State, path: Path) -> None:
    """Write a session, in place of the one before; the whole file or nothing.

    Parameters
    ----------
    state : State
        The session.
    path : Path
        The file; its folder is made if it is missing.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    data = {
        _VERSION_KEY: STATE_VERSION,
        "texts": dict(state.edited.texts),
        "scene": scene_to_dict(state.edited.loaded),
        "source": _absolute(state.edited.source),
        "recent": [_absolute(recent) for recent in state.recent],
        "tab": state.tab,
        "theme": state.theme,
    }
    content = json.dumps(data, ensure_ascii=False, indent=1).encode()

    def write(file: BinaryIO) -> None:
        file.write(content)

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be made a folder: {error.strerror}") from None
    write_atomically(path, write, force=True)


def _absolute(source: str) -> str:
    # The next start may be in another folder. Names of presets have no suffix.
    path = Path(source)
    return str(path.absolute()) if path.suffix else source


def load_state(path: Path) -> State | None:
    """Read the session of the last time.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    State or None
        None if there is no such file.

    Raises
    ------
    InputError
        If it cannot be read or is no session of this version; it is then kept aside under another
        name, which the message says.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        return _state(json.loads(content))
    except (InputError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        why = f"{error}" if isinstance(error, InputError) else "damaged"
        raise InputError(
            f"the last session could not be restored ({why}); {_put_aside(path)}"
        ) from None


def _state(data: Any) -> State:
    version = data[_VERSION_KEY]
    if version != STATE_VERSION:
        raise InputError(f"version {version!r}, not {STATE_VERSION}")
    loaded = scene_from_dict(data["scene"])
    texts = {name: field.text_of(loaded) for name, field in FIELDS.items()}
    texts |= {name: str(text) for name, text in data["texts"].items() if name in FIELDS}
    return State(
        edited=Edited(texts, loaded, str(data["source"])),
        recent=tuple(str(path) for path in data["recent"]),
        tab=str(data["tab"]),
        theme=str(data["theme"]),
    )


def _put_aside(path: Path) -> str:
    for number in range(1, _ASIDE):
        aside = path.with_name(f"{path.stem}.damaged-{number}{path.suffix}")
        if not aside.exists():
            try:
                path.rename(aside)
            except OSError:
                break
            return f"it is kept as {aside}"
    return f"it stays in {path}"

"""The configuration file with the user's keys and themes. Imports no Textual."""

import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fivtui.model import InputError, check_known, unknown_name_error

from .state_file import user_folder

_COLOUR: Final = re.compile(r"#[0-9a-fA-F]{6}")
# Colours of a theme; `primary` must be given.
_COLOURS: Final = (
    "primary",
    "secondary",
    "warning",
    "error",
    "success",
    "accent",
    "foreground",
    "background",
    "surface",
    "panel",
)
_ENTRIES: Final = ("theme", "live", "pictures", "keys", "themes")
# One key starts a run and stops the active one: `stop` has the key configured for `run`.
_RUN_ACTIONS: Final = ("run", "stop")


@dataclass(frozen=True, slots=True)
class Config:
    """Keys by action, the theme, and the colours of user themes by name.

    `live`: whether each edit of the scene updates the live curve, a run that is not kept; None
    keeps the setting of the last session. `pictures`: whether terminals that can show pictures
    show charts as pictures.
    """

    theme: str = ""
    live: bool | None = None
    pictures: bool = True
    keys: Mapping[str, str] = field(default_factory=dict)
    themes: Mapping[str, Mapping[str, str | bool]] = field(default_factory=dict)


def config_path(environment: Mapping[str, str] | None = None) -> Path:
    """The default configuration file.

    ``fivtui/config.toml`` in XDG_CONFIG_HOME, in APPDATA on Windows, or in ``~/.config``.
    """
    folder = user_folder("XDG_CONFIG_HOME", "APPDATA", "~/.config", environment)
    return folder / "config.toml"


def load_config(path: Path | None, actions: Collection[str]) -> Config:
    """Read keys for `actions`, theme and user themes; without a file, the defaults.

    Raises `InputError` if the file cannot be read or has an invalid entry.
    """
    try:
        data = {} if path is None else tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        data = {}
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"not TOML: {error}") from None
    for name in data:
        check_known("key", name, _ENTRIES)
    keys = {
        name: _read_text(f"keys.{name}", key) for name, key in _read_table("keys", data).items()
    }
    for name in keys:
        check_known("action", name, actions)
    run, stop = _RUN_ACTIONS
    if run in keys:
        keys[stop] = keys[run]
    themes = _read_table("themes", data)
    return Config(
        _read_text("theme", data.get("theme", "")),
        _read_switch("live", data.get("live")),
        _read_switch("pictures", data.get("pictures")) is not False,
        keys,
        {name: _read_theme(name, _read_table(name, themes)) for name in themes},
    )


def _read_table(name: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{name}: must be a table")
    return table


def _read_text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} = {value!r}: must be text in quotes")
    return value


def _read_switch(name: str, value: object) -> bool | None:
    if value is not None and not isinstance(value, bool):
        raise InputError(f"{name} = {value!r}: must be true or false")
    return value


def _read_theme(name: str, table: Mapping[str, Any]) -> Mapping[str, str | bool]:
    colours: dict[str, str | bool] = {}
    for key, value in table.items():
        if key == "dark":
            colours[key] = bool(value)
            continue
        if key not in _COLOURS:
            raise unknown_name_error(f"colour of theme {name}:", key, (*_COLOURS, "dark"))
        if _COLOUR.fullmatch(_read_text(key, value)) is None:
            raise InputError(f"themes.{name}.{key} = {value!r}: must be a colour such as '#E69F00'")
        colours[key] = value
    if "primary" not in colours:
        raise InputError(f"themes.{name}: must have the colour primary")
    return colours

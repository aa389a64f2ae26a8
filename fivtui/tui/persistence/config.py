"""The user's keys and themes, from a TOML file. Imports no Textual."""

import os
import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fivtui.model import InputError, check_known, unknown_name

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
_KEYS: Final = ("theme", "live", "keys", "themes")
# One key for two actions: it runs, or stops an active run.
_RUN: Final = ("run", "stop")


@dataclass(frozen=True, slots=True)
class Config:
    """Keys by action, the theme, and the colours of user themes by name.

    `live`: whether a live curve follows edits; None keeps the setting of the last session.
    """

    theme: str = ""
    live: bool | None = None
    keys: Mapping[str, str] = field(default_factory=dict)
    themes: Mapping[str, Mapping[str, str | bool]] = field(default_factory=dict)


def config_path(environment: Mapping[str, str] | None = None) -> Path:
    """The default file.

    ``fivtui/config.toml`` in XDG_CONFIG_HOME, in APPDATA on Windows, or in ``~/.config``.
    """
    variables = os.environ if environment is None else environment
    home = variables.get("XDG_CONFIG_HOME", "")
    if not Path(home).is_absolute():
        roaming = variables.get("APPDATA", "") if os.name == "nt" else ""
        home = roaming or str(Path("~/.config").expanduser())
    return Path(home) / "fivtui" / "config.toml"


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
        check_known("key", name, _KEYS)
    keys = {name: _text(f"keys.{name}", key) for name, key in _table("keys", data).items()}
    for name in keys:
        check_known("action", name, actions)
    keys |= {name: keys[_RUN[0]] for name in _RUN if _RUN[0] in keys}
    themes = _table("themes", data)
    return Config(
        _text("theme", data.get("theme", "")),
        _live(data.get("live")),
        keys,
        {name: _theme(name, _table(name, themes)) for name in themes},
    )


def _table(name: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{name}: must be a table")
    return table


def _text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} = {value!r}: must be text in quotes")
    return value


def _live(value: object) -> bool | None:
    if value is not None and not isinstance(value, bool):
        raise InputError(f"live = {value!r}: must be true or false")
    return value


def _theme(name: str, table: Mapping[str, Any]) -> Mapping[str, str | bool]:
    colours: dict[str, str | bool] = {}
    for key, value in table.items():
        if key == "dark":
            colours[key] = bool(value)
            continue
        if key not in _COLOURS:
            raise unknown_name(f"colour of theme {name}:", key, (*_COLOURS, "dark"))
        if _COLOUR.fullmatch(_text(key, value)) is None:
            raise InputError(f"themes.{name}.{key} = {value!r}: must be a colour such as '#E69F00'")
        colours[key] = value
    if "primary" not in colours:
        raise InputError(f"themes.{name}: must have the colour primary")
    return colours

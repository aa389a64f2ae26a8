"""The configuration file with the user's keys and themes. Imports no Textual."""

import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fivtui.model import InputError, check_known, unknown_name_error

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
# Types of the entries.
_ENTRIES: Final = {"theme": str, "live": bool, "pictures": bool, "keys": dict, "themes": dict}
_TYPE_TEXTS: Final = {str: "text in quotes", bool: "true or false", dict: "a table"}


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
    for name, value in data.items():
        _check_type(name, value, _ENTRIES[name])
    keys, themes = data.get("keys", {}), data.get("themes", {})
    for name, key in keys.items():
        check_known("action", name, actions)
        _check_type(f"keys.{name}", key, str)
    for name, theme in themes.items():
        _check_theme(name, theme)
    if "run" in keys:
        # One key starts a run and stops the active one.
        keys["stop"] = keys["run"]
    return Config(**data)


def _check_type(name: str, value: object, kind: type) -> None:
    if not isinstance(value, kind):
        raise InputError(f"{name} = {value!r}: must be {_TYPE_TEXTS[kind]}")


def _check_theme(name: str, theme: Any) -> None:
    _check_type(f"themes.{name}", theme, dict)
    for key, value in theme.items():
        path = f"themes.{name}.{key}"
        if key == "dark":
            _check_type(path, value, bool)
        elif key not in _COLOURS:
            raise unknown_name_error(f"colour of theme {name}:", key, (*_COLOURS, "dark"))
        elif not isinstance(value, str) or _COLOUR.fullmatch(value) is None:
            raise InputError(f"{path} = {value!r}: must be a colour such as '#E69F00'")
    if "primary" not in theme:
        raise InputError(f"themes.{name}: must have the colour primary")

"""Differences between scenes, for lists and command lines. Imports no Textual."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.model import ALL_PARAMETERS, NONE_TEXT
from fivtui.scene import DEFAULT_PRESET, PRESETS, Scene
from fivtui.transient import SETTINGS

from .equations import symbol_of
from .fields import FIELDS, scene_texts

# Key and text of the tables over time, which have no field in the form.
_TABLES_KEY: Final = "over_time"
_OVER_TIME_TEXT: Final = "over time"


@dataclass(frozen=True, slots=True)
class Difference:
    """A field whose text differs between two scenes, and its text in the first."""

    name: str
    text: str

    @property
    def arguments(self) -> list[str]:
        """The arguments that set the field on the command line; no option sets tables over time."""
        if self.name in ALL_PARAMETERS:
            return ["--set", f"{self.name}={self.text or NONE_TEXT}"]
        return SETTINGS[self.name].command_options(self.text)

    def __str__(self) -> str:
        if self.name == _TABLES_KEY:
            return f"{self.text or 'nothing'} {_OVER_TIME_TEXT}"
        return f"{symbol_of(self.name)}={self.text.replace(' ', '')}"


def differences(scene: Scene, origin: Scene) -> list[Difference]:
    """The fields in which `scene` differs from `origin`, then the tables over time."""
    origin_texts = scene_texts(origin)
    fields = [
        Difference(name, text)
        for name, text in scene_texts(scene).items()
        if text != origin_texts[name]
    ]
    tables = dict(scene.over_time)
    if tables != dict(origin.over_time):
        # List a table over time, but not its value at t = 0, which is the field's text.
        fields = [difference for difference in fields if difference.name not in tables]
        fields.append(Difference(_TABLES_KEY, ", ".join(map(symbol_of, tables))))
    return fields


def change_texts(scene: Scene, edited: Scene) -> list[str]:
    """The fields of `scene` that differ from the edited scene, such as ``F=80 (now 200)``."""
    edited_texts, changes = _texts(edited), []
    tables, edited_tables = dict(scene.over_time), dict(edited.over_time)
    for name, text in _texts(scene).items():
        edited_text = edited_texts[name] or NONE_TEXT
        if tables.get(name) != edited_tables.get(name) and text == edited_text:
            edited_text = "another table"
        if edited_text != (text or NONE_TEXT):
            changes.append(f"{symbol_of(name)}={text or NONE_TEXT} (now {edited_text})")
    return changes


def _texts(scene: Scene) -> dict[str, str]:
    return scene_texts(scene) | {name: _OVER_TIME_TEXT for name, _ in scene.over_time}


def legend_names(scenes: Mapping[int, Scene]) -> list[str]:
    """Legend entries of numbered runs: the differences of their scenes, or else their numbers."""
    texts = [_texts(scene) for scene in scenes.values()]
    varied_fields = [name for name in FIELDS if len({text[name] for text in texts}) > 1]
    names = [", ".join(_legend_entry(name, text[name]) for name in varied_fields) for text in texts]
    counts = Counter(names)

    def unique_name(number: int, name: str) -> str:
        if not name:
            return f"run {number}"
        return name if counts[name] == 1 else f"{name}, run {number}"

    return list(map(unique_name, scenes, names))


def _legend_entry(name: str, text: str) -> str:
    if name in ("method", "accuracy") and text:
        return text
    field = FIELDS[name]
    unit = field.unit if text not in ("", _OVER_TIME_TEXT) and name in ALL_PARAMETERS else ""
    return f"{symbol_of(name)} {text or field.when_empty} {unit}".rstrip()


def base_scene() -> Scene:
    """The base scene: the default of the command line and of the form."""
    return PRESETS[DEFAULT_PRESET]

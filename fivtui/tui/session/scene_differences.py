"""Differences between scenes, for lists and command lines. Imports no Textual."""

from collections import Counter
from collections.abc import Mapping
from typing import Final

from fivtui.model import ALL_PARAMETERS, NONE_TEXT
from fivtui.scene import DEFAULT_PRESET, PRESETS, Scene

from .equations import symbol_of
from .fields import FIELDS, scene_texts

# Text of a parameter that follows a table over time.
_OVER_TIME_TEXT: Final = "over time"


def _texts(scene: Scene) -> dict[str, str]:
    return scene_texts(scene) | {name: _OVER_TIME_TEXT for name, _ in scene.over_time}


def differences(scene: Scene, origin: Scene) -> dict[str, str]:
    """The fields in which two scenes differ, with their texts in the first."""
    tables, origin_tables = dict(scene.over_time), dict(origin.over_time)
    origin_texts = _texts(origin)
    return {
        name: text
        for name, text in _texts(scene).items()
        if text != origin_texts[name] or tables.get(name) != origin_tables.get(name)
    }


def difference_text(scene: Scene, origin: Scene) -> str:
    """The fields in which `scene` differs from `origin`, such as ``F=90, μ=over time``."""
    texts = differences(scene, origin)
    return ", ".join(f"{symbol_of(name)}={text.replace(', ', ',')}" for name, text in texts.items())


def change_texts(scene: Scene, edited: Scene) -> list[str]:
    """The fields of `scene` that differ from the edited scene, such as ``F=80 (now 200)``."""
    edited_texts, changes = _texts(edited), []
    for name, text in differences(scene, edited).items():
        edited_text = edited_texts[name] or NONE_TEXT
        if edited_text == text:
            edited_text = "another table"
        changes.append(f"{symbol_of(name)}={text or NONE_TEXT} (now {edited_text})")
    return changes


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

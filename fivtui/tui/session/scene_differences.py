"""Differences between scenes, for lists and command lines. Imports no Textual."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.model import ALL_PARAMETERS, NONE
from fivtui.scene import DEFAULT_PRESET, PRESETS, Scene
from fivtui.transient import SETTINGS

from .equations import symbol_of
from .fields import FIELDS

# Key of the tables over time, for which there is no field.
_TABLES: Final = "over_time"
_OVER_TIME: Final = "over time"


@dataclass(frozen=True, slots=True)
class Difference:
    """A field in which a scene differs from another, with its new text."""

    name: str
    text: str

    @property
    def arguments(self) -> list[str]:
        """The option on the command line."""
        if self.name in ALL_PARAMETERS:
            return ["--set", f"{self.name}={self.text or NONE}"]
        return SETTINGS[self.name].command_options(self.text)

    def __str__(self) -> str:
        if self.name == _TABLES:
            return f"{self.text or 'nothing'} {_OVER_TIME}"
        return f"{symbol_of(self.name)}={self.text.replace(' ', '')}"


def differences(scene: Scene, origin: Scene) -> list[Difference]:
    """The fields in which two scenes differ, followed by the tables over time."""
    fields = [
        Difference(name, field.text_of(scene))
        for name, field in FIELDS.items()
        if field.text_of(scene) != field.text_of(origin)
    ]
    tables = dict(scene.over_time)
    if tables != dict(origin.over_time):
        # A table is listed instead of its value at t = 0.
        fields = [difference for difference in fields if difference.name not in tables]
        fields.append(Difference(_TABLES, ", ".join(map(symbol_of, tables))))
    return fields


def _texts(scene: Scene) -> dict[str, str]:
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return texts | {name: _OVER_TIME for name, _ in scene.over_time}


def legend_names(scenes: Mapping[int, Scene]) -> list[str]:
    """Legend entries of numbered runs: the differences of their scenes, or else their numbers."""
    texts = [_texts(scene) for scene in scenes.values()]
    varied = [name for name in FIELDS if len({text[name] for text in texts}) > 1]
    names = [", ".join(_entry(name, text[name]) for name in varied) for text in texts]
    counts = Counter(names)
    return [
        name if counts[name] == 1 and name else ", ".join(filter(None, [name, f"run {number}"]))
        for number, name in zip(scenes, names, strict=True)
    ]


def _entry(name: str, text: str) -> str:
    if name in ("method", "accuracy") and text:
        return text
    field = FIELDS[name]
    unit = field.unit if text not in ("", _OVER_TIME) and name in ALL_PARAMETERS else ""
    return f"{symbol_of(name)} {text or field.when_empty} {unit}".rstrip()


def default_scene() -> Scene:
    """The default scene of the command line."""
    return PRESETS[DEFAULT_PRESET]

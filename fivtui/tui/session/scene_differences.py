"""Differences between scenes, for lists and command lines. Imports no Textual."""

from dataclasses import dataclass

from fivtui.model import ALL_PARAMETERS, NONE
from fivtui.scene import DEFAULT_PRESET, PRESETS, Scene

from .fields import CONSIDERED, FIELDS


@dataclass(frozen=True, slots=True)
class Difference:
    """A field in which a scene differs from another, with its new text."""

    name: str
    text: str

    @property
    def words(self) -> list[str]:
        """The option on the command line."""
        if self.name in ALL_PARAMETERS:
            return ["--set", f"{self.name}={self.text or NONE}"]
        if self.name == "separation":
            return ["--ignore-separation"] if self.text != CONSIDERED else []
        if self.name == "accuracy":
            return [f"--error={part.strip()}" for part in self.text.split(",") if part.strip()]
        return [f"--{self.name.replace('_', '-')}={self.text.replace(' ', '')}"]

    def __str__(self) -> str:
        return f"{self.name}={self.text.replace(' ', '')}"


def differences(scene: Scene, origin: Scene) -> list[Difference]:
    """The fields in which a scene differs from another."""
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return [
        Difference(name, text)
        for name, text in texts.items()
        if text != FIELDS[name].text_of(origin)
    ]


def base_scene() -> Scene:
    """The default scene of the command line."""
    return PRESETS[DEFAULT_PRESET]

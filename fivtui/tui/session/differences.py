"""In what a scene differs from another, for lists and command lines. Imports no Textual."""

from dataclasses import dataclass

from fivtui.model.parameters import PARAMETERS
from fivtui.scene.presets import DEFAULT_PRESET, PRESETS
from fivtui.scene.scene import Scene

from .fields import CONSIDERED, FIELDS


@dataclass(frozen=True, slots=True)
class Difference:
    """A field in which a scene differs from another: its new text, and how to say it in a shell."""

    name: str
    text: str

    @property
    def words(self) -> list[str]:
        """The words on the command line."""
        if self.name in PARAMETERS:
            return ["--set", f"{self.name}={self.text}"]
        if self.name == "separation":
            return ["--ignore-separation"] if self.text != CONSIDERED else []
        if self.name == "accuracy":
            return [f"--error={part.strip()}" for part in self.text.split(",") if part.strip()]
        return [f"--{self.name.replace('_', '-')}={self.text.replace(' ', '')}"]

    def __str__(self) -> str:
        return f"{self.name}={self.text.replace(' ', '')}"


def differences(scene: Scene, origin: Scene) -> list[Difference]:
    """In which fields two scenes differ.

    Parameters
    ----------
    scene, origin : Scene
        The scene, and that from which it is thought to be made.

    Returns
    -------
    list of Difference
        In the order of the fields.
    """
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return [
        Difference(name, text)
        for name, text in texts.items()
        if text != FIELDS[name].text_of(origin)
    ]


def base_scene() -> Scene:
    """The scene that the command line takes when it is given none."""
    return PRESETS[DEFAULT_PRESET]

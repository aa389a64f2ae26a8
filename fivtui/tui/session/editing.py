"""Texts being edited, from a scene, with undo. Imports no Textual."""

from fivtui.scene.scene import Scene

from .differences import base_scene
from .fields import FIELDS
from .history import Edited, History


def _edited(scene: Scene, source: str) -> Edited:
    texts = {name: field.text_of(scene) for name, field in FIELDS.items()}
    return Edited(texts, scene, source)


class Editing:
    """The text of every field, and the way back.

    Parameters
    ----------
    scene : Scene, optional
        The scene to begin with; the base scene if not given.
    source : str, optional
        How the command line would name it: a preset or a file; the base scene if not given.

    Attributes
    ----------
    texts : dict of str
        Text of every field, valid or not.
    source : str
        How the command line names the scene loaded; empty if it cannot.
    """

    def __init__(self, scene: Scene | None = None, source: str = "") -> None:
        self._history = History()
        self._take(_edited(base_scene() if scene is None else scene, source))

    def _take(self, state: Edited) -> None:
        self.texts, self._loaded, self.source = dict(state.texts), state.loaded, state.source

    @property
    def edited(self) -> Edited:
        """What is being edited now; to be given to `restore`, in this session or another."""
        return Edited(dict(self.texts), self._loaded, self.source)

    def restore(self, state: Edited) -> None:
        """Bring back what was edited before, as one step that can be undone.

        Parameters
        ----------
        state : Edited
            Texts, valid or not, and the scene from which they were made.
        """
        self._history.close()
        self._history.before(self.edited, "restore")
        self._history.close()
        self._take(state)

    def close_step(self) -> None:
        """Let the next edit be undone by itself, also where it continues the last one."""
        self._history.close()

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to undo."""
        return self._history.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to do again."""
        return self._history.can_redo

    def undo(self) -> bool:
        """Undo the last edit; whether there was one."""
        return self._turn(self._history.undo(self.edited))

    def redo(self) -> bool:
        """Do again what was undone last; whether there was anything."""
        return self._turn(self._history.redo(self.edited))

    def _turn(self, state: Edited | None) -> bool:
        if state is None:
            return False
        self._take(state)
        return True

    def load(self, scene: Scene, source: str = "") -> None:
        """Replace all texts by those of a scene.

        Parameters
        ----------
        scene : Scene
            The scene.
        source : str
            How the command line would name it; empty if it cannot.
        """
        self.restore(_edited(scene, source))

    def saved(self, scene: Scene, source: str) -> None:
        """Take note that what is edited was saved; no edit, so nothing to undo.

        Parameters
        ----------
        scene : Scene
            The scene as it was written.
        source : str
            The file.
        """
        self._history.saved(self._loaded, scene, source)
        self._loaded, self.source = scene, source

    @property
    def loaded(self) -> Scene:
        """The scene loaded, as it is without the edits."""
        return self._loaded

    @property
    def name(self) -> str:
        """Name of the scene loaded."""
        return self._loaded.name

    @property
    def description(self) -> str:
        """Description of the scene loaded."""
        return self._loaded.description

    @property
    def changed(self) -> list[str]:
        """Names of the fields whose text differs from that of the scene loaded."""
        return [
            name
            for name, field in FIELDS.items()
            if self.texts[name] != field.text_of(self._loaded)
        ]

    def set_text(self, name: str, text: str) -> None:
        """Edit a field.

        Parameters
        ----------
        name : str
            Its name.
        text : str
            Its new text, valid or not.
        """
        if self.texts[name] != text:
            self._set(name, text, "type")

    def _set(self, name: str, text: str, how: str) -> None:
        self._history.before(self.edited, f"{how} {name}")
        self.texts[name] = text

    def reset(self, name: str) -> None:
        """Give a field the text it has in the scene loaded."""
        self._set(name, FIELDS[name].text_of(self._loaded), "reset")
        self.close_step()

    def reset_all(self) -> None:
        """Give every field the text it has in the scene loaded."""
        self.load(self._loaded, self.source)

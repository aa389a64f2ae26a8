"""Undo and redo of edits. Imports no Textual."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.scene.scene import Scene

_MOST: Final = 1000


@dataclass(frozen=True, slots=True)
class Edited:
    """What is being edited, at one moment.

    Attributes
    ----------
    texts : mapping of str to str
        Text of every field; never changed.
    loaded : Scene
        The scene from which the texts were made.
    source : str
        How the command line names that scene.
    """

    texts: Mapping[str, str]
    loaded: Scene
    source: str


class History:
    """The states before and after the present one.

    Edits of one kind that follow each other are one step, until `close` is called: a number typed
    is undone at once, and so is a row of nudges.
    """

    def __init__(self) -> None:
        self._past: list[Edited] = []
        self._future: list[Edited] = []
        self._kind = ""

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to redo."""
        return bool(self._future)

    def before(self, state: Edited, kind: str) -> None:
        """Take note of the state that an edit is about to change.

        Parameters
        ----------
        state : Edited
            The state.
        kind : str
            What is edited, and how; edits of the same kind become one step.
        """
        self._future.clear()
        if kind != self._kind:
            self._past.append(state)
            del self._past[:-_MOST]
        self._kind = kind

    def close(self) -> None:
        """Let the next edit begin a step of its own."""
        self._kind = ""

    def saved(self, before: Scene, after: Scene, source: str) -> None:
        """Take note that a scene has a file now: going back does not part from it.

        Parameters
        ----------
        before, after : Scene
            The scene from which the texts were made, and as it was written.
        source : str
            The file.
        """
        for states in (self._past, self._future):
            states[:] = [
                Edited(state.texts, after, source) if state.loaded is before else state
                for state in states
            ]

    def undo(self, state: Edited) -> Edited | None:
        """Go a step back.

        Parameters
        ----------
        state : Edited
            The present state, to come back to.

        Returns
        -------
        Edited or None
            The state before; None if there is none.
        """
        return self._turned(state, self._past, self._future)

    def redo(self, state: Edited) -> Edited | None:
        """Go a step forth again.

        Parameters
        ----------
        state : Edited
            The present state.

        Returns
        -------
        Edited or None
            The state that was undone; None if there is none.
        """
        return self._turned(state, self._future, self._past)

    def _turned(self, state: Edited, source: list[Edited], target: list[Edited]) -> Edited | None:
        self.close()
        if not source:
            return None
        target.append(state)
        return source.pop()

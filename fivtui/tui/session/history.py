"""Undo and redo. Imports no Textual."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fivtui.scene import Scene

_MOST: Final = 1000


@dataclass(frozen=True, slots=True)
class Edited:
    """Edited texts, the scene they were made from, and its preset or file."""

    texts: Mapping[str, str]
    loaded: Scene
    source: str


class History:
    """Past and undone states.

    Consecutive edits of one kind are one step until `close`: a typed number is undone at once.
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
        """Record the state before an edit; consecutive edits of one `kind` are one step."""
        self._future.clear()
        if kind != self._kind:
            self._past.append(state)
            del self._past[:-_MOST]
        self._kind = kind

    def close(self) -> None:
        """Make the next edit a separate step."""
        self._kind = ""

    def saved(self, before: Scene, after: Scene, source: str) -> None:
        """Make states of the scene `before` belong to its saved version `after`."""
        for states in (self._past, self._future):
            states[:] = [
                Edited(state.texts, after, source) if state.loaded is before else state
                for state in states
            ]

    def undo(self, state: Edited) -> Edited | None:
        """The previous state, None if there is none; `state` becomes redoable."""
        return self._turned(state, self._past, self._future)

    def redo(self, state: Edited) -> Edited | None:
        """The next undone state, None if there is none; `state` becomes undoable."""
        return self._turned(state, self._future, self._past)

    def _turned(self, state: Edited, source: list[Edited], target: list[Edited]) -> Edited | None:
        self.close()
        if not source:
            return None
        target.append(state)
        return source.pop()

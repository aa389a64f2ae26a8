"""Undo and redo. Imports no Textual."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

from fivtui.scene import OverTime, Scene

_MOST: Final = 1000
_MOST_ACTIONS: Final = 20


@dataclass(frozen=True, slots=True)
class Edited:
    """Edited texts and tables over time, the scene they were made from, its preset or file."""

    texts: Mapping[str, str]
    over_time: OverTime
    loaded: Scene
    source: str


@dataclass(frozen=True, slots=True)
class Action:
    """A step that is no edit of texts: what undoes it and what does it again."""

    undo: Callable[[], None]
    redo: Callable[[], None]


Step = Edited | Action


class History:
    """Past and undone steps: states before edits, and actions.

    Consecutive edits of one kind are one step until `close`: a typed number is undone at once.
    """

    def __init__(self) -> None:
        self._past: list[Step] = []
        self._future: list[Step] = []
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

    def record(self, action: Action) -> None:
        """Record an action that has been done."""
        self.close()
        self._future.clear()
        self._past.append(action)
        # Actions may hold results.
        for old in [step for step in self._past if isinstance(step, Action)][:-_MOST_ACTIONS]:
            self._past.remove(old)

    def close(self) -> None:
        """Make the next edit a separate step."""
        self._kind = ""

    def saved(self, before: Scene, after: Scene, source: str) -> None:
        """Make states of the scene `before` belong to its saved version `after`."""
        for states in (self._past, self._future):
            states[:] = [
                replace(state, loaded=after, source=source)
                if isinstance(state, Edited) and state.loaded is before
                else state
                for state in states
            ]

    def undo(self, state: Edited) -> Edited | None:
        """The state before the last step, None if there is none; `state` becomes redoable."""
        step = self._turned(state, self._past, self._future)
        if isinstance(step, Action):
            step.undo()
            return state
        return step

    def redo(self, state: Edited) -> Edited | None:
        """The state after the next undone step, None if there is none."""
        step = self._turned(state, self._future, self._past)
        if isinstance(step, Action):
            step.redo()
            return state
        return step

    def _turned(self, state: Edited, source: list[Step], target: list[Step]) -> Step | None:
        self.close()
        if not source:
            return None
        step = source.pop()
        target.append(step if isinstance(step, Action) else state)
        return step

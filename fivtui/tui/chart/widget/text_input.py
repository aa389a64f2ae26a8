"""A text input that drops no character."""

from collections.abc import Callable
from typing import Any

from textual.events import Paste
from textual.widgets import Input


def _unchanged(text: str) -> str:
    return text


class TextInput(Input):
    """An input of one line that keeps all typed or pasted characters.

    `respell` may exchange characters of the text for others, such as a decimal comma for a point;
    it keeps their number.
    """

    def __init__(
        self, value: str, *, respell: Callable[[str], str] = _unchanged, **options: Any
    ) -> None:
        super().__init__(value, **options)
        self._respell = respell

    def replace(self, text: str, start: int, end: int) -> None:
        """Replace the text between two positions, and respell the result."""
        begin, finish = sorted((max(start, 0), min(end, len(self.value))))
        self.value = self._respell(f"{self.value[:begin]}{text}{self.value[finish:]}")
        self.cursor_position = begin + len(text)

    def _on_paste(self, event: Paste) -> None:
        # Join lines, and replace unprintable characters by blanks.
        lines = (line.strip() for line in event.text.splitlines())
        joined = " ".join(filter(None, lines))
        self.replace("".join(s if s.isprintable() else " " for s in joined), *self.selection)
        event.stop()
        event.prevent_default()

"""A text input that corrects its text while it is typed, and joins pasted lines."""

from collections.abc import Callable
from typing import Any

from textual.events import Paste
from textual.widgets import Input


class TextInput(Input):
    """An input of one line; pasted lines are joined.

    `replace_commas` returns the text with points in place of decimal commas; it keeps the number of
    characters.
    """

    def __init__(
        self, value: str, *, replace_commas: Callable[[str], str] = str, **options: Any
    ) -> None:
        super().__init__(value, **options)
        self._replace_commas = replace_commas

    def replace(self, text: str, start: int, end: int) -> None:
        """Replace the text between two positions, and call `replace_commas` with the result."""
        # A selection made backwards has its end before its start.
        first, stop = sorted((max(start, 0), min(end, len(self.value))))
        self.value = self._replace_commas(f"{self.value[:first]}{text}{self.value[stop:]}")
        self.cursor_position = first + len(text)

    def _on_paste(self, event: Paste) -> None:
        # Join lines, and replace unprintable characters by blanks.
        lines = (line.strip() for line in event.text.splitlines())
        joined = " ".join(filter(None, lines))
        printable = "".join(sign if sign.isprintable() else " " for sign in joined)
        self.replace(printable, *self.selection)
        event.stop()
        event.prevent_default()

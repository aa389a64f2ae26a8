"""A text input that corrects its text while it is typed, and joins pasted lines."""

from collections.abc import Callable
from typing import Any, Final

from textual.events import Paste
from textual.keys import KEY_NAME_REPLACEMENTS
from textual.widgets import Input

# Names of keys that type a sign, of which Textual does not find the sign.
_SIGN_KEYS: Final = frozenset(KEY_NAME_REPLACEMENTS.values())


class TextInput(Input):
    """An input of one line; pasted lines are joined.

    `replace_commas` returns the text with points in place of decimal commas; it keeps the number of
    characters.
    """

    def __init__(
        self, value: str, *, replace_commas: Callable[[str], str] = str, **options: Any
    ) -> None:
        self._replace_commas = replace_commas
        super().__init__(value, **options)

    def check_consume_key(self, key: str, character: str | None) -> bool:
        """Whether a key types text."""
        return key in _SIGN_KEYS or super().check_consume_key(key, character)

    def validate_value(self, value: str) -> str:
        """The text to display for a typed or pasted one."""
        return self._replace_commas(value)

    def _on_paste(self, event: Paste) -> None:
        # Join lines, and replace unprintable characters by blanks.
        lines = (line.strip() for line in event.text.splitlines())
        joined = " ".join(filter(None, lines))
        printable = "".join(sign if sign.isprintable() else " " for sign in joined)
        self.replace(printable, *self.selection)
        event.stop()
        event.prevent_default()

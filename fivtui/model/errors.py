"""The two errors that users see, and cancellation."""

import re
from typing import Final

_LONGEST_WORD: Final = 240
_LONGEST_TEXT: Final = 2000
# Characters shown at both ends of a shortened text.
_HEAD_OF_WORD, _TAIL_OF_WORD = 120, 60
_HEAD_OF_TEXT, _TAIL_OF_TEXT = 1200, 600
_LONG_WORD: Final = re.compile(rf"\S{{{_LONGEST_WORD + 1},}}")


def one_line(text: str) -> str:
    """A message as one printable line, at most about 2000 characters long.

    Control characters become escapes; words over 240 characters are cut in the middle.
    """
    if not text.isprintable():
        text = "".join(_printable(character) for character in text)
    text = _LONG_WORD.sub(lambda match: _cut(match[0], _HEAD_OF_WORD, _TAIL_OF_WORD), text)
    return text if len(text) <= _LONGEST_TEXT else _cut(text, _HEAD_OF_TEXT, _TAIL_OF_TEXT)


def _printable(character: str) -> str:
    if character.isprintable():
        return character
    return character.encode("unicode_escape", "surrogatepass").decode("ascii")


def _cut(text: str, head: int, tail: int) -> str:
    return f"{text[:head]}…({len(text) - head - tail} characters)…{text[-tail:]}"


class InputError(ValueError):
    """A wrong input, reported in one line: what is wrong, where, and what it must be."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class ComputationError(RuntimeError):
    """A computation that cannot finish.

    Parameters
    ----------
    why : str
        What stopped the computation, and when.
    advice : str
        What to try instead.
    """

    def __init__(self, why: str, advice: str) -> None:
        self.why = one_line(why)
        self.advice = one_line(advice)
        super().__init__(self.why, self.advice)

    def __str__(self) -> str:
        return f"{self.why}; {self.advice}"


class Cancelled(Exception):
    """Raised when a progress callback asks to stop."""

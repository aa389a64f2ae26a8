"""The two errors that users see, and cancellation."""

import re
from typing import Final

_MAX_WORD_LENGTH: Final = 240
_MAX_TEXT_LENGTH: Final = 2000
# Numbers of characters that remain at the start and the end of a shortened text.
_WORD_HEAD, _WORD_TAIL = 120, 60
_TEXT_HEAD, _TEXT_TAIL = 1200, 600
_LONG_WORD: Final = re.compile(rf"\S{{{_MAX_WORD_LENGTH + 1},}}")


def one_line(text: str) -> str:
    """A message as one printable line of at most about 2000 characters.

    Control characters are escaped; words over 240 characters are shortened in the middle.
    """
    if not text.isprintable():
        text = "".join(_escape(character) for character in text)
    text = _LONG_WORD.sub(lambda match: _shorten(match[0], _WORD_HEAD, _WORD_TAIL), text)
    return text if len(text) <= _MAX_TEXT_LENGTH else _shorten(text, _TEXT_HEAD, _TEXT_TAIL)


def _escape(character: str) -> str:
    if character.isprintable():
        return character
    return character.encode("unicode_escape", "surrogatepass").decode("ascii")


def _shorten(text: str, head: int, tail: int) -> str:
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

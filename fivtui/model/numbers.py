"""Parsing of numbers from users: plain text, finite, within an interval."""

import math
import reprlib
from dataclasses import dataclass
from numbers import Real
from typing import Final

from .errors import InputError

_SHORT_REPR: Final = reprlib.Repr()
_SHORT_REPR.maxstring = 40


@dataclass(frozen=True, slots=True)
class Interval:
    """The numbers from `lower` to `upper`; its text is, say, ``above 0 and at most 1e+09 kg``."""

    lower: float
    upper: float = math.inf
    unit: str = ""
    lower_open: bool = False
    optional: bool = False

    def __str__(self) -> str:
        return f"none, or {self._range_text}" if self.optional else self._range_text

    @property
    def _range_text(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if self.upper == math.inf:
            return f"{'above' if self.lower_open else 'at least'} {self.lower:g}{unit}"
        if self.lower_open:
            return f"above {self.lower:g} and at most {self.upper:g}{unit}"
        return f"from {self.lower:g} to {self.upper:g}{unit}"

    def check(self, name: str, value: object) -> float:
        """Return `value`, a number or its text, as a float; messages call it `name`.

        Raises `InputError` if it is not a finite number within the interval.
        """
        number = parse_number(name, value, self)
        too_low = number <= self.lower if self.lower_open else number < self.lower
        if too_low or number > self.upper:
            raise InputError(f"{name} = {number:g}: must be {self}")
        return number


def parse_number(name: str, value: object, allowed: object) -> float:
    """Read a finite number from a number (Python's or NumPy's) or its text."""
    if isinstance(value, bool) or not isinstance(value, (float, str, Real)):
        raise InputError(f"{name} = {value!r}: not a number; must be {allowed}")
    try:
        number = read_number(value) if isinstance(value, str) else float(value)
    except (ValueError, OverflowError):
        text = _SHORT_REPR.repr(value)
        raise InputError(f"{name} = {text}: not a number; must be {allowed}") from None
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: not a finite number; must be {allowed}")
    return number


def read_number(text: str) -> float:
    """Read a number from plain text: ASCII, no ``_``; ``inf`` and ``nan`` are accepted.

    Raises `ValueError` if the text is not a number.
    """
    return float(_check_plain(text))


def read_integer(text: str) -> int:
    """Read an integer from plain text; raises `ValueError` if it is not one."""
    return int(_check_plain(text))


def _check_plain(text: str) -> str:
    # Refuse texts that Python accepts, such as 1_0 and digits of other scripts.
    if not text.isascii() or "_" in text:
        raise ValueError("not a plain number")
    return text

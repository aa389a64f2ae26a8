"""Ranges of a named quantity as text: ``NAME=START:STOP:COUNT[:log]``."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .model import PARAMETERS, InputError, ParameterSpec, read_whole, unknown_name

MAX_COUNT: Final = 10_000_000
_FORM: Final = "NAME=START:STOP:COUNT or NAME=START:STOP:COUNT:log"
_FORM_OF_ENDS: Final = "NAME=START:STOP or NAME=START:STOP:log"
_SPACING: Final = "log"


@dataclass(frozen=True, slots=True)
class NamedRange:
    """`count` values of a quantity from `start` to `stop`, with `log` spaced logarithmically."""

    name: str
    start: float
    stop: float
    count: int
    log: bool = False

    def values(self) -> NDArray[np.float64]:
        """The values, shape (count,); the ends are exact."""
        space = np.geomspace if self.log else np.linspace
        values: NDArray[np.float64] = space(self.start, self.stop, self.count)
        return values


def parse_range(
    flag: str,
    text: str,
    specs: Mapping[str, ParameterSpec] = PARAMETERS,
    *,
    counted: bool = True,
) -> NamedRange:
    """Parse a range.

    Parameters
    ----------
    flag : str
        The option it was given to, for messages, e.g. ``"--vary"``.
    text : str
        ``NAME=START:STOP:COUNT``, or ``NAME=START:STOP:COUNT:log`` for logarithmic spacing.
    specs : mapping of str to ParameterSpec
        Quantities that may vary, with their bounds; the model's parameters by default.
    counted : bool
        Whether the text has a count; if not, the range has its two ends alone.

    Raises
    ------
    InputError
        If the text has another form, the name is unknown, an end is out of bounds, the ends are
        equal, the count is not from 2 to 10 000 000, or a logarithmic range is not above 0.
    """
    name, equals, rest = text.partition("=")
    name, parts = name.strip(), [part.strip() for part in rest.split(":")]
    form, example = (_FORM, "F=10:120:23") if counted else (_FORM_OF_ENDS, "F=10:120")
    if not counted:
        parts.insert(2, "2")
    if not equals or not name or len(parts) not in (3, 4):
        raise InputError(f"{flag} {text}: must be {form}, e.g. {flag} {example}")
    if name not in specs:
        raise unknown_name("parameter", name, specs)
    log = len(parts) == 4
    if log and parts[3] != _SPACING:
        raise InputError(f"{flag} {text}: unknown spacing {parts[3]!r}; must be {form}")
    start, stop = (specs[name].check(part) for part in parts[:2])
    if start == stop:
        raise InputError(f"{flag} {text}: START and STOP must differ; --set gives a single value")
    if log and min(start, stop) <= 0.0:
        raise InputError(f"{flag} {text}: START and STOP must be above 0 in a logarithmic range")
    return NamedRange(name, start, stop, _count(flag, text, parts[2]), log)


def parse_ranges(
    flag: str, texts: Sequence[str], specs: Mapping[str, ParameterSpec] = PARAMETERS
) -> tuple[NamedRange, ...]:
    """Parse several ranges as `parse_range`; `InputError` also if a name appears twice."""
    ranges = tuple(parse_range(flag, text, specs) for text in texts)
    names = [each.name for each in ranges]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{flag} {name}=…: given twice; every name must have one range")
    return ranges


def _count(flag: str, text: str, part: str) -> int:
    try:
        count = read_whole(part)
    except ValueError:
        count = 0
    if not 2 <= count <= MAX_COUNT:
        raise InputError(
            f"{flag} {text}: COUNT = {part}: must be a whole number from 2 to {MAX_COUNT}"
        )
    return count


def number_text(value: float) -> str:
    """The shortest text of exactly this number, without a trailing ``.0``."""
    if value == 0.0:
        return "0"
    brief = f"{value:.12g}"
    return brief if float(brief) == value and math.isfinite(value) else repr(value)


def range_text(name: str, values: NDArray[np.float64]) -> str:
    """``START:STOP:COUNT`` of these values; `InputError` if they are not evenly spaced."""
    first, last, count = float(values[0]), float(values[-1]), values.size
    ends = f"{number_text(first)}:{number_text(last)}:{count}"
    if np.array_equal(values, np.linspace(first, last, count)):
        return ends
    if min(first, last) > 0.0 and np.array_equal(values, np.geomspace(first, last, count)):
        return f"{ends}:{_SPACING}"
    raise InputError(f"{name}: its values are not evenly spaced; a command cannot say them")

"""Ranges of a named quantity as text, ``NAME=START:STOP:COUNT[:log]``, and their values."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .model import PARAMETERS, InputError, ParameterSpec, check_known, parameter_spec, read_integer

MAX_COUNT: Final = 10_000_000
_FORM: Final = "NAME=START:STOP:COUNT or NAME=START:STOP:COUNT:log"
_ENDS_FORM: Final = "NAME=START:STOP or NAME=START:STOP:log"
_SPACING: Final = "log"
_FRACTION: Final = r"([0-9]*(?:[eE][+-]?[0-9]*)?)"
_COMMA_IN_NUMBER: Final = re.compile(rf"(\s*[+-]?[0-9]*),{_FRACTION}(\s*%?\s*)")
# A decimal comma in a part of a range: the number has a colon behind it or before it. A comma
# between numbers without colons separates the values of a list.
_COMMA_IN_PART: Final = re.compile(
    rf"((?:^|[\s=~])[+-]?[0-9]*),{_FRACTION}(?=\s*:)|(:\s*[+-]?[0-9]*),{_FRACTION}(?=[\s:]|$)"
)
# Entries of the table of 2^(n/64), and terms of the series of eˣ − 1 between two entries.
_TABLE_SIZE: Final = 64
_SERIES_TERMS: Final = 7
# Decimal numbers of 50 digits.
_PRECISE: Final = Context(prec=50)
_LN2: Final = _PRECISE.ln(Decimal(2))
# Values in files may come from the powers of a mathematical library, which differ from
# `log_spaced` in their last bits: relative tolerance of the comparison.
_LIBRARY_RTOL: Final = 1e-13
# Veltkamp's constant splits a number into halves of its bits.
_SPLITTER: Final = 2.0**27 + 1.0

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class NamedRange:
    """`count` values of a quantity from `start` to `stop`, with `log` spaced logarithmically."""

    name: str
    start: float
    stop: float
    count: int
    log: bool = False

    def values(self) -> Floats:
        """The values, shape (count,); the ends are exact."""
        return _spaced_values(self.start, self.stop, self.count, log=self.log)


def parse_range(
    flag: str,
    text: str,
    specs: Mapping[str, ParameterSpec] = PARAMETERS,
    *,
    counted: bool = True,
) -> NamedRange:
    """Parse a range as ``NAME=START:STOP:COUNT[:log]``; messages name `flag`.

    `specs` are the allowed names. Without `counted` the text has no COUNT, and the range has two
    values.
    """
    name, equals, range_part = text.partition("=")
    name, parts = name.strip(), [part.strip() for part in range_part.split(":")]
    form, example = (_FORM, "F=10:120:23") if counted else (_ENDS_FORM, "F=10:120")
    if not counted:
        # The count of both ends.
        parts.insert(2, "2")
    if not equals or not name or len(parts) not in (3, 4):
        raise InputError(f"{flag} {text}: must be {form}, e.g. {flag} {example}")
    check_known("parameter", name, specs)
    log = len(parts) == 4
    if log and parts[3] != _SPACING:
        raise InputError(f"{flag} {text}: unknown spacing {parts[3]!r}; must be {form}")
    start, stop = (specs[name].check(part) for part in parts[:2])
    if start == stop:
        raise InputError(f"{flag} {text}: START and STOP must differ; --set gives a single value")
    if log and min(start, stop) <= 0.0:
        raise InputError(f"{flag} {text}: START and STOP must be above 0 in a logarithmic range")
    return NamedRange(name, start, stop, _read_count(flag, text, parts[2]), log)


def parse_ranges(
    flag: str, texts: Sequence[str], specs: Mapping[str, ParameterSpec] = PARAMETERS
) -> tuple[NamedRange, ...]:
    """Parse several ranges as `parse_range`; `InputError` also if a name appears twice."""
    ranges = tuple(parse_range(flag, text, specs) for text in texts)
    names = [named_range.name for named_range in ranges]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{flag} {name}=…: given twice; every name must have one range")
    return ranges


def parse_ends(
    text: str, example: str, *, flag: str = ""
) -> tuple[str, tuple[float, float] | None]:
    """A parameter and the ends of its range, as ``NAME`` or ``NAME=LOW:HIGH``."""
    name, equals, ends = (part.strip() for part in text.partition("="))
    spec = parameter_spec(name)
    if not equals:
        return name, None
    parts = ends.split(":")
    if len(parts) != 2:
        label = f"{flag} " if flag else ""
        raise InputError(f"{label}{text}: must be NAME or NAME=LOW:HIGH, e.g. {label}{example}")
    low, high = (spec.check(part.strip()) for part in parts)
    return name, (low, high)


def _read_count(flag: str, text: str, part: str) -> int:
    try:
        count = read_integer(part)
    except ValueError:
        count = 0
    if not 2 <= count <= MAX_COUNT:
        raise InputError(
            f"{flag} {text}: COUNT = {part}: must be a whole number from 2 to {MAX_COUNT}"
        )
    return count


def with_decimal_point(text: str) -> str:
    """The text of a number, perhaps as a percentage, with a point in place of a decimal comma."""
    number = _COMMA_IN_NUMBER.fullmatch(text)
    return text if number is None else f"{number[1]}.{number[2]}{number[3]}"


def with_decimal_points(text: str) -> str:
    """The text of ranges with points in place of decimal commas; commas of lists stay."""

    def with_point(match: re.Match[str]) -> str:
        return match[0].replace(",", ".")

    return _COMMA_IN_PART.sub(with_point, text)


def number_text(value: float) -> str:
    """The shortest text of exactly this number, without a trailing ``.0``."""
    if value == 0.0:
        return "0"
    short = f"{value:.12g}"
    return short if float(short) == value and math.isfinite(value) else repr(value)


def range_text(name: str, values: Floats) -> str:
    """``START:STOP:COUNT`` of these values; `InputError` if they are not evenly spaced."""
    start, stop, count = float(values[0]), float(values[-1]), values.size
    text = f"{number_text(start)}:{number_text(stop)}:{count}"
    if np.array_equal(values, _spaced_values(start, stop, count, log=False)):
        return text
    if min(start, stop) > 0.0 and np.allclose(
        values, _spaced_values(start, stop, count, log=True), rtol=_LIBRARY_RTOL, atol=0.0
    ):
        return f"{text}:{_SPACING}"
    raise InputError(f"{name}: its values are not evenly spaced; START:STOP:COUNT cannot give them")


def _spaced_values(start: float, stop: float, count: int, *, log: bool) -> Floats:
    if not log:
        return np.linspace(start, stop, count)
    values = log_spaced(start, stop, np.arange(count, dtype=float), count - 1)
    values[0], values[-1] = start, stop
    return values


def log_spaced(start: float, stop: float, indices: Floats, steps: int = 1) -> Floats:
    """Values start (stop/start)^(index/steps), with the same bits on every machine.

    Powers by a mathematical library differ in their last bits between processors. This function
    uses only sums, products and roundings, which IEEE 754 defines.
    """
    # Logarithms are to the base 2^(1/64). Numbers of two floats have a high and a low part.
    start_log, stop_log = (
        _PRECISE.multiply(_log2(end), Decimal(_TABLE_SIZE)) for end in (start, stop)
    )
    start_high, start_low = _split_decimal(start_log)
    step_high, step_low = _split_decimal(
        _PRECISE.divide(_PRECISE.subtract(stop_log, start_log), Decimal(steps))
    )
    product, product_error = _exact_product(step_high, indices)
    total = start_high + product
    # The rounding error of the sum (Knuth) and all smaller terms.
    added = total - start_high
    residue = (
        (start_high - (total - added))
        + (product - added)
        + (product_error + indices * step_low + start_low)
    )
    integer = np.rint(total)
    remainder = ((total - integer) + residue) * (float(_LN2) / _TABLE_SIZE)
    power = integer.astype(np.int64)
    high, low = _power_table()
    table_index = power % _TABLE_SIZE
    # e^remainder − 1
    series = np.zeros_like(remainder)
    for n in range(_SERIES_TERMS, 0, -1):
        series = (series + 1.0) * remainder / n
    value = high[table_index] + (low[table_index] + high[table_index] * series)
    spaced: Floats = np.ldexp(value, power // _TABLE_SIZE)
    return spaced


def _log2(number: float) -> Decimal:
    return _PRECISE.divide(_PRECISE.ln(Decimal(number)), _LN2)


def _split_decimal(number: Decimal) -> tuple[float, float]:
    # A number of more than 53 bits as the nearest double and the remainder.
    nearest = float(number)
    return nearest, float(_PRECISE.subtract(number, Decimal(nearest)))


@lru_cache(maxsize=1)
def _power_table() -> tuple[Floats, Floats]:
    # 2^(n/64) as high and low parts.
    size = Decimal(_TABLE_SIZE)
    exact = [_PRECISE.power(Decimal(2), Decimal(n) / size) for n in range(_TABLE_SIZE)]
    pairs = np.array([_split_decimal(power) for power in exact])
    return pairs[:, 0], pairs[:, 1]


def _exact_product(a: float, b: Floats) -> tuple[Floats, Floats]:
    # The product and its rounding error (Dekker).
    product = a * b
    a_high, b_high = (_SPLITTER * x - (_SPLITTER * x - x) for x in (a, b))
    a_low, b_low = a - a_high, b - b_high
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return product, error

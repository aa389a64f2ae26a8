"""Columns of the paper's tables, trends along lines, and tests built from them."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from fivtui.paper import FloatArray, PaperResults

from .claim import Finding, Test, Values


def columns(paper: PaperResults, key: str, name: str) -> dict[float, FloatArray]:
    """A column of every line of a panel, by the value that distinguishes the lines."""
    return {value: line[name] for value, line in paper.table(key).lines()}


def compare(values: Callable[[PaperResults], Values], holds: Callable[..., bool]) -> Test:
    """The test that computes values and compares them by `holds`."""

    def test(paper: PaperResults) -> Finding:
        computed = values(paper)
        return holds(*computed), computed

    return test


def trend(
    rule: Callable[[FloatArray], bool], lines: Iterable[FloatArray], *indices: int
) -> Finding:
    """Whether all lines follow a rule, and their values at the indices."""
    all_lines = list(lines)
    return all(map(rule, all_lines)), [line[index] for line in all_lines for index in indices]


def rises(values: FloatArray | Sequence[float]) -> bool:
    """Whether each value is greater than the one before."""
    return bool(np.all(np.diff(values) > 0.0))


def falls(values: FloatArray | Sequence[float]) -> bool:
    """Whether each value is less than the one before."""
    return bool(np.all(np.diff(values) < 0.0))


def falls_then_rises(values: FloatArray) -> bool:
    """Whether values fall to a minimum before the last one, and rise from there."""
    least = int(np.argmin(values))
    inside = 0 < least < values.size - 1
    return inside and falls(values[: least + 1]) and rises(values[least:])


def crossing(along: FloatArray, excess: FloatArray) -> float | None:
    """Where values change sign from negative or zero to positive, interpolated.

    None if there is no such place, or more than one change of sign.
    """
    positive = excess > 0.0
    if positive[0] or np.count_nonzero(np.diff(positive)) != 1:
        return None
    before = int(np.argmax(positive)) - 1
    share = excess[before] / (excess[before] - excess[before + 1])
    return float(along[before] + share * (along[before + 1] - along[before]))

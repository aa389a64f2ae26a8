"""Columns of the paper's tables, trends along lines, and tests built from them.

A panel of a figure has several lines. A test returns whether a claim holds, and computed numbers.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from fivtui.paper import FloatArray, PaperResults

from .claim import Finding, Test, Values


def columns(paper: PaperResults, key: str, name: str) -> dict[float, FloatArray]:
    """A column of every line of a panel, by the value that distinguishes the lines."""
    return {value: line[name] for value, line in paper.table(key).lines()}


def build_test(values: Callable[[PaperResults], Values], holds: Callable[..., bool]) -> Test:
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
    minimum = int(np.argmin(values))
    is_inside = 0 < minimum < values.size - 1
    return is_inside and falls(values[: minimum + 1]) and rises(values[minimum:])


def crossing(along: FloatArray, excess: FloatArray) -> float | None:
    """The value of `along` above which `excess` is positive, by linear interpolation.

    None if `excess` is positive at first, or does not change its sign exactly once.
    """
    is_positive = excess > 0.0
    if is_positive[0] or np.count_nonzero(np.diff(is_positive)) != 1:
        return None
    last_index = int(np.argmax(is_positive)) - 1
    share = excess[last_index] / (excess[last_index] - excess[last_index + 1])
    return float(along[last_index] + share * (along[last_index + 1] - along[last_index]))

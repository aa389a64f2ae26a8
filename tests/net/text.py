"""Recorded outputs of commands, files and calls, as text in sections.

The net, `tests.net`, is the set of recordings: it shows changes of the program's output. Recordings
are without run-dependent parts, and compared number by number.

A section begins with a line ``$ title``; fresh output is compared with the recorded section.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui import __version__

RECORDED: Final = Path(__file__).parent / "recorded"
RELATIVE_TOLERANCE: Final = 1e-9
# Small numbers may consist of rounding errors. So two numbers are also equal if they differ by less
# than LINE_TOLERANCE times the largest number in their lines, or both are below ABSOLUTE_TOLERANCE.
LINE_TOLERANCE: Final = 1e-12
ABSOLUTE_TOLERANCE: Final = 1e-10
# A longer list is recorded as its length, a selection of items, and the sum of magnitudes.
MAX_NUMBERS: Final = 24
MAX_ITEMS: Final = 6
# Begins the title of a section.
SECTION_MARK: Final = "$ "
# In the report of differences: unequal lines per section, width of their excerpts, and characters
# before the first difference.
_MAX_REPORTED_LINES: Final = 4
_EXCERPT_WIDTH: Final = 160
_EXCERPT_LEAD: Final = 60

# Patterns of text that varies, with their replacements.
_MASKS: Final = (
    (re.escape(__version__), "<version>"),
    (r"\b[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\b", "<guid>"),
    (r"\b\d{4}-\d\d-\d\d([T ]\d\d:\d\d:\d\d(\.\d+)?(Z|\+00:00)?)?", "<date>"),
    (r" at 0x[0-9a-f]+", ""),
    (r"\b\d\d:\d\d:\d\d\b", "<time>"),
    (r"peak to (\S+) in \S+ s", r"peak to \1 in <time>"),
    (r"(?m)^CPU time .*$", "CPU time <time>"),
    # The progress of a sweep, in computed members.
    (r"(?m)^fivtui: \d+ of \d+ members .*\n", ""),
    (r"[^\s'\"]*/tests/net/inputs/", "<inputs>/"),
    # Rows of a trade-off: method and setting (group 1), CPU time, errors (group 2), and marks of
    # the errors for which the setting is best: F final state, P peak, H half peak-to-peak, E
    # events. Time and marks vary.
    (r"(?m)^(\S.*? (?:tol|step)=\S+) +\S+(.*? [+-]\d+)(?: +[FPHE]+)?$", r"\1 <time>\2"),
)
# Names whose values differ between runs or machines: CPU times, versions, and `transients`. In
# stored sweeps the latter is a hash of test runs, which identifies the arithmetic of a machine.
_VARYING: Final = re.compile(
    r"(^|_)(cpu|wall)_(s|ms)$|^cpu_time|^(fivtui|numpy|scipy|version|transients)$"
)
_NUMBER: Final = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w])")


def mask_varying(text: str, folder: Path | None = None) -> str:
    """Mask paths, versions, identifiers, dates and CPU times in a text."""
    if folder is not None:
        text = text.replace(str(folder), "<folder>")
    for pattern, replacement in _MASKS:
        text = re.sub(pattern, replacement, text)
    return "\n".join(line.rstrip() for line in text.split("\n"))


def data_lines(value: Any, path: str = "") -> Iterator[str]:
    """JSON data as lines of path and value; a list of numbers is one line."""
    if _VARYING.search(path.rpartition(".")[2]):
        yield f"{path}: <varies>"
    elif isinstance(value, Mapping) and value:
        for key, entry in value.items():
            yield from data_lines(entry, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and any(isinstance(entry, (Mapping, list)) for entry in value):
        yield f"{path}: {len(value)} items"
        for index in _selected_indices(len(value), MAX_ITEMS):
            yield from data_lines(value[index], f"{path}[{index}]")
    elif isinstance(value, list):
        yield column_line(path, value)
    else:
        yield f"{path}: {_as_text(value)}"


def column_line(name: str, values: Sequence[Any]) -> str:
    """A column of numbers or texts as one line."""
    if _VARYING.search(name):
        return f"{name} [{len(values)}]: <varies>"
    shown = [_as_text(values[index]) for index in _selected_indices(len(values), MAX_NUMBERS)]
    line = f"{name} [{len(values)}]: {' '.join(shown)}"
    if len(values) > MAX_NUMBERS:
        numbers = [
            abs(value)
            for value in values
            if isinstance(value, (int, float)) and math.isfinite(value)
        ]
        line += f" sum of sizes {math.fsum(numbers)!r}"
    return line


def array_line(name: str, values: Any) -> str:
    """An array of any shape as one line."""
    array = np.asarray(values)
    shape = "" if array.ndim == 1 else f" {array.dtype} {array.shape}"
    return column_line(name + shape, array.ravel().tolist())


def _as_text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, default=str)


def _selected_indices(count: int, limit: int) -> list[int]:
    # Indices of at most `limit` evenly spaced items, with the first and the last.
    if count <= limit:
        return list(range(count))
    return sorted({round(index * (count - 1) / (limit - 1)) for index in range(limit)})


def sections_of(text: str) -> dict[str, list[str]]:
    """The sections of a recording by their first lines."""
    sections: dict[str, list[str]] = {}
    title = ""
    for line in text.splitlines():
        if line.startswith(SECTION_MARK):
            title = line
            # The same command may be run again.
            while title in sections:
                title += " (again)"
            sections[title] = []
        else:
            sections.setdefault(title, []).append(line)
    return sections


def same_line(recorded: str, fresh: str) -> bool:
    """Whether two lines have equal words, and numbers within the tolerance."""
    if recorded == fresh:
        return True
    recorded_texts, fresh_texts = _NUMBER.findall(recorded), _NUMBER.findall(fresh)
    if recorded_texts == fresh_texts:
        # The lines differ in words or blanks.
        return False
    # Numbers of different width shift the text beside them: compare the words without blanks.
    masked_lines = {" ".join(_NUMBER.sub("#", line).split()) for line in (recorded, fresh)}
    if len(recorded_texts) != len(fresh_texts) or len(masked_lines) > 1:
        return False
    pairs = list(zip(map(float, recorded_texts), map(float, fresh_texts), strict=True))
    finite_sizes = [abs(number) for pair in pairs for number in pair if math.isfinite(number)]
    tolerance = LINE_TOLERANCE * max(finite_sizes, default=0.0)
    return all(
        math.isclose(old, new, rel_tol=RELATIVE_TOLERANCE, abs_tol=tolerance)
        or max(abs(old), abs(new)) < ABSOLUTE_TOLERANCE
        for old, new in pairs
    )


def differences(recorded: str, fresh: str) -> list[str]:
    """Differences between two recordings: titles of sections and their lines."""
    old_sections, new_sections = sections_of(recorded), sections_of(fresh)
    report = []
    for title in dict.fromkeys([*old_sections, *new_sections]):
        if title not in new_sections:
            report += [title, "    no longer there"]
        elif title not in old_sections:
            report += [title, "    not recorded"]
        else:
            lines = zip_longest(old_sections[title], new_sections[title], fillvalue="(no line)")
            unequal = [(old, new) for old, new in lines if not same_line(old, new)]
            # Lines that differ only by a shift come last.
            unequal.sort(key=lambda pair: pair[0].split() == pair[1].split())
            report += [title] if unequal else []
            for old, new in unequal[:_MAX_REPORTED_LINES]:
                report += _difference_excerpt(old, new)
            if len(unequal) > _MAX_REPORTED_LINES:
                report.append(f"    {len(unequal) - _MAX_REPORTED_LINES} further lines differ")
    return report


def _difference_excerpt(old: str, new: str) -> list[str]:
    # A long line is shown from shortly before the first difference.
    pairs = enumerate(zip(old, new, strict=False))
    first_difference = next((index for index, (before, after) in pairs if before != after), 0)
    is_long = max(len(old), len(new)) > _EXCERPT_WIDTH
    begin = max(first_difference - _EXCERPT_LEAD, 0) if is_long else 0
    end = begin + _EXCERPT_WIDTH
    return [f"  - {old[begin:end]}", f"  + {new[begin:end]}"]

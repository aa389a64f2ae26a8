"""Console output of attractors, continuations and basins."""

from collections.abc import Sequence

import numpy as np

from fivtui.console import number, print_list, print_rows

from .attractor_continuation import Continuation
from .attractor_search import Coexistence
from .basins import Basin
from .explorer import Attractor
from .phrases import coexistence_phrase

_HEADER = (
    "attractor",
    "period s",
    "half peak-to-peak m",
    "y from .. to m",
    "separations",
    "off the belt s",
    "greatest vx m/s",
    "multipliers, size",
)
_DIGITS = 5


def print_attractors(attractors: Sequence[Attractor]) -> None:
    """Print attractors, one row each."""
    rows = [_attractor_row(attractor) for attractor in attractors]
    if not any(attractor.orbit is not None and attractor.orbit.sticks for attractor in attractors):
        print_rows("Attractors", _HEADER, rows)
        return
    sticks = [_stick_texts(attractor) for attractor in attractors]
    print_rows(
        "Attractors",
        (*_HEADER[:6], "sticks", "time of stick s", *_HEADER[6:]),
        [(*row[:6], *stick_text, *row[6:]) for row, stick_text in zip(rows, sticks, strict=True)],
    )


def _stick_texts(attractor: Attractor) -> tuple[str, str]:
    orbit = attractor.orbit
    if orbit is None:
        return "", ""
    share = f"{orbit.stick_time / orbit.period:.1%}"
    return str(orbit.sticks), f"{number(orbit.stick_time, _DIGITS)} ({share})"


def _attractor_row(attractor: Attractor) -> tuple[str, ...]:
    orbit = attractor.orbit
    if orbit is None:
        return (str(attractor.kind), *([""] * (len(_HEADER) - 1)))
    return (
        str(attractor.kind),
        number(orbit.period, 8),
        number(orbit.half_range),
        f"{number(orbit.y_min, _DIGITS)} .. {number(orbit.y_max, _DIGITS)}",
        str(orbit.separations),
        f"{number(orbit.separated_time, _DIGITS)} ({orbit.separated_time / orbit.period:.1%})",
        number(orbit.vx_max, _DIGITS),
        "  ".join(number(float(size), 3) for size in np.abs(orbit.multipliers)),
    )


def print_coexistence(result: Coexistence) -> None:
    """Print the attractors of a parameter set."""
    print_attractors(result.attractors)
    print_list("", [("found", coexistence_phrase(result))])
    if result.escape is not None:
        rows = [
            (f"offset {where} that leaves the equilibrium", _offset_text(value))
            for where, value in (("above", result.escape.up), ("below", result.escape.down))
        ]
        print_list("", rows)


def _offset_text(value: float | None) -> str:
    return "none" if value is None else f"{number(value)} m"


def print_continuation(result: Continuation) -> None:
    """Print the attractors along a parameter, one row each."""
    header = (result.name, *_HEADER[:6], "found going")
    rows = [
        (number(point.value), *_attractor_row(point.attractor)[:6], ", ".join(point.directions))
        for point in result.points
    ]
    print_rows("Attractors, followed up and down", header, rows, keys=2)


def print_basin(result: Basin) -> None:
    """Print the number of starts that reach each attractor."""
    total = result.grid.size
    rows = [
        (attractor.description, f"{count} of {total} starts ({count / total:.1%})")
        for attractor, count in zip(result.attractors, result.counts, strict=True)
    ]
    print_list("Basins of attraction", rows)

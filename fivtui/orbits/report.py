"""Console output of attractors, continuations and basins."""

from collections.abc import Sequence

import numpy as np

from fivtui.console import number, print_list, print_rows

from .attractor_search import Coexistence
from .basins import Basin
from .branches import Continuation
from .cycle_branches import CycleBranch
from .explorer import Attractor
from .files import describe, event_words
from .words import coexistence_words

_HEADER = (
    "attractor",
    "period s",
    "half peak-to-peak m",
    "y from .. to m",
    "separations",
    "off the belt s",
    "least belt speed m/s",
    "multipliers, size",
)
_SHORT = 5


def print_attractors(found: Sequence[Attractor]) -> None:
    """Print attractors, one row each."""
    print_rows("Attractors", _HEADER, [_row(attractor) for attractor in found])


def _row(attractor: Attractor) -> tuple[str, ...]:
    orbit = attractor.orbit
    if orbit is None:
        return (str(attractor.kind), *([""] * (len(_HEADER) - 1)))
    return (
        str(attractor.kind),
        number(orbit.period, 8),
        number(orbit.half_range),
        f"{number(orbit.y_min, _SHORT)} .. {number(orbit.y_max, _SHORT)}",
        str(orbit.separations),
        f"{number(orbit.separated_time, _SHORT)} ({orbit.separated_time / orbit.period:.1%})",
        number(max(orbit.vx_max, 0.0), _SHORT),
        "  ".join(number(float(size), 3) for size in np.abs(orbit.multipliers)),
    )


def print_coexistence(result: Coexistence) -> None:
    """Print the attractors of a parameter set."""
    print_attractors(result.attractors)
    print_list("", [("found", coexistence_words(result))])
    if result.escape is not None:
        rows = [
            (f"offset {where} that leaves the equilibrium", _offset(value))
            for where, value in (("above", result.escape.up), ("below", result.escape.down))
        ]
        print_list("", rows)


def _offset(value: float | None) -> str:
    return "none" if value is None else f"{number(value)} m"


def print_continuation(result: Continuation) -> None:
    """Print the attractors along a parameter, one row each."""
    header = (result.name, *_HEADER[:6], "found going")
    rows = [
        (number(point.value), *_row(point.attractor)[:6], ", ".join(point.directions))
        for point in result.points
    ]
    print_rows("Attractors, followed up and down", header, rows, keys=2)


def print_branch(result: CycleBranch) -> None:
    """Print a branch of limit cycles, one row each, and what happens along it."""
    name = result.name
    rows = [
        (
            number(point.value, 8),
            number(point.period, 8),
            f"{number(point.y_min, _SHORT)} .. {number(point.y_max, _SHORT)}",
            "stable" if point.stable else "unstable",
            "  ".join(number(abs(value), 3) for value in point.multipliers),
        )
        for point in result.points
    ]
    header = (name, "period s", "y from .. to m", "limit cycle", "multipliers, size")
    print_rows("Branch of limit cycles", header, rows)
    events = [
        (
            event_words(event),
            number(event.value, 10),
            number(event.period, 8),
            f"{number(event.y_min, _SHORT)} .. {number(event.y_max, _SHORT)}",
        )
        for event in result.events
    ]
    print_rows("Events", ("event", *header[:3]), events)
    print_list(
        "", [("the branch begins where it", result.ends[0]), ("it ends where it", result.ends[1])]
    )


def print_basin(result: Basin) -> None:
    """Print how many starts reach which attractor."""
    total = result.reached.size
    rows = []
    for place, attractor in enumerate(result.attractors):
        count = int(np.count_nonzero(result.reached == place))
        rows.append((describe(attractor), f"{count} of {total} starts ({count / total:.1%})"))
    print_list("Basins of attraction", rows)

"""Console output of attractors, basins, branches and curves, and phrases about attractors."""

from collections.abc import Iterable, Sequence
from typing import Final

from fivtui.console import number, print_list, print_rows

from .attractor_continuation import Continuation
from .attractor_search import Coexistence
from .basins import Basin
from .boundaries.result import Boundary, BoundaryEvent, BoundaryPoint
from .curves.result import BranchEvent, CycleBranch, CyclePoint
from .explorer import Attractor, Kind
from .shooting import PeriodicOrbit

Measured = PeriodicOrbit | CyclePoint | BranchEvent | BoundaryPoint | BoundaryEvent

_HEADER: Final = (
    "attractor",
    "period s",
    "half peak-to-peak m",
    "y from .. to m",
    "separations",
    "off the belt s",
    "greatest vx m/s",
    "multipliers, size",
)
# Columns before those of sticks. Cycles stick only to belts with a `v_belt`: without it the belt is
# always faster than the slider.
_COLUMNS_BEFORE_STICKS: Final = 6
# Significant digits: of most numbers, of parameters and periods, of parameters at events, and of
# multipliers.
_DIGITS: Final = 5
_PERIOD_DIGITS: Final = 8
_EVENT_DIGITS: Final = 10
_MULTIPLIER_DIGITS: Final = 3
# Names of the points of a curve over two parameters, by kind.
_POINT_NAMES: Final = {"hopf": "Hopf points", "fold": "folds", "touch": "touching cycles"}


def print_attractors(attractors: Sequence[Attractor]) -> None:
    """Print attractors, one row each."""
    rows = [_attractor_row(attractor) for attractor in attractors]
    if not any(attractor.orbit is not None and attractor.orbit.sticks for attractor in attractors):
        print_rows("Attractors", _HEADER, rows)
        return
    count = _COLUMNS_BEFORE_STICKS
    print_rows(
        "Attractors",
        (*_HEADER[:count], "sticks", "time of stick s", *_HEADER[count:]),
        [
            (*row[:count], *_stick_texts(attractor), *row[count:])
            for row, attractor in zip(rows, attractors, strict=True)
        ],
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
        number(orbit.period, _PERIOD_DIGITS),
        number(orbit.half_range),
        _y_range(orbit),
        str(orbit.separations),
        f"{number(orbit.separated_time, _DIGITS)} ({orbit.separated_time / orbit.period:.1%})",
        number(orbit.vx_max, _DIGITS),
        _sizes(orbit.multipliers),
    )


def _y_range(record: Measured) -> str:
    # Lowest and highest point.
    return f"{number(record.y_min, _DIGITS)} .. {number(record.y_max, _DIGITS)}"


def _sizes(multipliers: Iterable[complex]) -> str:
    # Absolute values of Floquet multipliers.
    return "  ".join(number(float(abs(value)), _MULTIPLIER_DIGITS) for value in multipliers)


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
    count = _COLUMNS_BEFORE_STICKS
    header = (result.name, *_HEADER[:count], "found going")
    rows = [
        (number(point.value), *_attractor_row(point.attractor)[:count], ", ".join(point.directions))
        for point in result.points
    ]
    # Value and attractor identify a row.
    print_rows("Attractors, followed up and down", header, rows, keys=2)


def print_basin(result: Basin) -> None:
    """Print the number of starts that reach each attractor."""
    total = result.grid.size
    rows = [
        (attractor.description, f"{count} of {total} starts ({count / total:.1%})")
        for attractor, count in zip(result.attractors, result.counts, strict=True)
    ]
    print_list("Basins of attraction", rows)


def print_branch(result: CycleBranch) -> None:
    """Print a branch of limit cycles, one row each, and its events."""
    name = result.name
    rows = [
        (
            number(point.value, _PERIOD_DIGITS),
            number(point.period, _PERIOD_DIGITS),
            _y_range(point),
            "stable" if point.stable else "unstable",
            _sizes(point.multipliers),
        )
        for point in result.points
    ]
    header = (name, "period s", "y from .. to m", "limit cycle", "multipliers, size")
    print_rows("Branch of limit cycles", header, rows)
    events = [
        (
            event.description,
            number(event.value, _EVENT_DIGITS),
            number(event.period, _PERIOD_DIGITS),
            _y_range(event),
        )
        for event in result.events
    ]
    print_rows("Events", ("event", *header[:3]), events)
    print_list(
        "", [("the branch begins where it", result.ends[0]), ("it ends where it", result.ends[1])]
    )


def print_boundary(result: Boundary) -> None:
    """Print the points of every curve, one row each, and its events."""
    header = (*result.names, "period s", "y from .. to m")
    for index, curve in enumerate(result.curves, start=1):
        position = f" {index} of {len(result.curves)}" if len(result.curves) > 1 else ""
        rows = [
            (
                *(number(value, _PERIOD_DIGITS) for value in point.values),
                number(point.period, _PERIOD_DIGITS),
                _y_range(point),
            )
            for point in curve.points
        ]
        print_rows(f"Curve of {_POINT_NAMES[result.kind]}{position}", header, rows)
        if curve.events:
            events = [
                (
                    str(event.kind),
                    *(number(value, _EVENT_DIGITS) for value in event.values),
                    number(event.period, _PERIOD_DIGITS),
                    _y_range(event),
                )
                for event in curve.events
            ]
            print_rows("Events", ("event", *header), events)
        print_list(
            "", [("the curve begins where it", curve.ends[0]), ("it ends where it", curve.ends[1])]
        )


def coexistence_phrase(result: Coexistence, since: str = "") -> str:
    """One phrase about the limit cycles and the unbounded motion of a parameter set.

    A knock is a disturbance after which motion does not return to a stable equilibrium. The text
    `since` says from which parameter on they exist, for example `` from μ = 0.2779``.

    Examples: ``a limit cycle coexists: half peak-to-peak 7.443 m (after a knock)``, and ``no limit
    cycle found from 11 starts``.
    """
    start_count = len(result.reached)
    verb, cause = "coexist" if result.coexists else "attract", _cause_text(result)
    cycles = [attractor for attractor in result.others if attractor.orbit is not None]
    sizes = " and ".join(f"{attractor.half_range:#.4g} m" for attractor in cycles)
    parts = []
    if len(cycles) == 1:
        parts.append(f"a limit cycle {verb}s{since}: half peak-to-peak {sizes}{cause}")
    elif cycles:
        parts.append(f"{len(cycles)} limit cycles {verb}{since}: half peak-to-peak {sizes}{cause}")
    if any(attractor.kind is Kind.UNBOUNDED for attractor in result.others):
        parts.append(f"motion grows without bounds{cause}")
    if not parts:
        parts.append(f"no limit cycle found from {start_count} starts")
    unsettled = sum(result.attractors[index].kind is Kind.UNSETTLED for index in result.reached)
    if unsettled:
        parts.append(f"from {unsettled} of {start_count} starts motion did not settle")
    return "; ".join(parts)


def transients_phrase(result: Coexistence) -> str:
    """One phrase about what transients reach on a belt of finite speed, at the set's μ.

    On a belt that is always faster than the slider, the safe friction is searched instead.
    """
    p, start_count = result.parameters, len(result.reached)
    # Branches refuse belts that run backward.
    is_backward = p.v_belt is not None and p.v_belt < 0.0
    command = "attractors --vary mu=0.2:1:9" if is_backward else "branch --vary mu --from cycle"
    return (
        f"transients from {start_count} starts at μ = {p.mu:g}: {coexistence_phrase(result)}; the "
        "least friction with limit cycles is not searched on a belt of finite speed "
        f"(fivtui {command} follows a cycle along μ)"
    )


def _cause_text(result: Coexistence) -> str:
    # How motion leaves the basin of a stable equilibrium.
    if not result.coexists:
        return ""
    # The static start is the first.
    reached_from_static = result.attractors[result.reached[0]]
    leaves = any(attractor is reached_from_static for attractor in result.others)
    return " (from the static start)" if leaves else " (after a knock)"

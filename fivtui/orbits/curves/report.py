"""Console output of branches of limit cycles."""

from typing import Final

from fivtui.console import number, print_list, print_rows

from .result import CycleBranch

_DIGITS: Final = 5


def print_branch(result: CycleBranch) -> None:
    """Print a branch of limit cycles, one row each, and its events."""
    name = result.name
    rows = [
        (
            number(point.value, 8),
            number(point.period, 8),
            f"{number(point.y_min, _DIGITS)} .. {number(point.y_max, _DIGITS)}",
            "stable" if point.stable else "unstable",
            "  ".join(number(abs(value), 3) for value in point.multipliers),
        )
        for point in result.points
    ]
    header = (name, "period s", "y from .. to m", "limit cycle", "multipliers, size")
    print_rows("Branch of limit cycles", header, rows)
    events = [
        (
            event.description,
            number(event.value, 10),
            number(event.period, 8),
            f"{number(event.y_min, _DIGITS)} .. {number(event.y_max, _DIGITS)}",
        )
        for event in result.events
    ]
    print_rows("Events", ("event", *header[:3]), events)
    print_list(
        "", [("the branch begins where it", result.ends[0]), ("it ends where it", result.ends[1])]
    )

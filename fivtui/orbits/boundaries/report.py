"""Console output of curves over two parameters."""

from typing import Final

from fivtui.console import number, print_list, print_rows

from .result import Boundary

_DIGITS: Final = 5


def print_boundary(result: Boundary) -> None:
    """Print the points of every curve, one row each, and its events."""
    header = (*result.names, "period s", "y from .. to m")
    for index, curve in enumerate(result.curves, start=1):
        numbering = f" {index} of {len(result.curves)}" if len(result.curves) > 1 else ""
        rows = [
            (
                *(number(value, 8) for value in point.values),
                number(point.period, 8),
                f"{number(point.y_min, _DIGITS)} .. {number(point.y_max, _DIGITS)}",
            )
            for point in curve.points
        ]
        print_rows(f"Curve of {_POINT_NAMES[result.kind]}{numbering}", header, rows)
        if curve.events:
            events = [
                (
                    str(event.kind),
                    *(number(value, 10) for value in event.values),
                    number(event.period, 8),
                    f"{number(event.y_min, _DIGITS)} .. {number(event.y_max, _DIGITS)}",
                )
                for event in curve.events
            ]
            print_rows("Events", ("event", *header), events)
        print_list(
            "", [("the curve begins where it", curve.ends[0]), ("it ends where it", curve.ends[1])]
        )


_POINT_NAMES: Final = {"hopf": "Hopf points", "fold": "folds", "touch": "touching cycles"}

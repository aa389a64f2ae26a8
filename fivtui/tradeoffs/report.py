"""Console output of a trade-off."""

import math
from typing import Final

from fivtui.console import number, print_list, print_rows
from fivtui.transient import QUANTITIES

from .files import pareto_fronts
from .measure import Tradeoff
from .settings import MeasuredSetting, cheapest

# Letters of quantities in the column of the settings that are best for them.
_MARKS: Final = {"final": "F", "peak": "P", "half_range": "H", "events": "E"}


def settings_table(result: Tradeoff) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Columns and rows of all settings; the last column names what each is best for."""
    on_belt = result.scene.parameters.v_belt is not None
    header = (
        "method",
        "setting",
        "CPU ms",
        "steps",
        "final state",
        "peak |y|",
        "half peak-to-peak",
        "events s",
        "separations",
        *(("sticks",) if on_belt else ()),
        "best for",
    )
    fronts = pareto_fronts(result)
    rows = []
    for row in result.rows:
        marks = "".join(mark for name, mark in _MARKS.items() if row in fronts[name])
        rows.append(_cells(row, marks, on_belt))
    return header, rows


def print_tradeoff(result: Tradeoff) -> None:
    """Print the settings, the cost of features, and the cheapest setting for each error target."""
    header, rows = settings_table(result)
    title = f"Trade-off: {result.scene.name}, {result.scene.t_end:g} s"
    # Two columns, method and setting, identify a row where a wide table is split into blocks.
    print_rows(title, header, rows, keys=2)
    floor = ", ".join(f"{name} {result.floor.of(name):.0e}" for name in QUANTITIES)
    notes = [
        (
            "best for",
            "no other setting has less error in less time: F final state, P peak, H half "
            "peak-to-peak over the second half of the run, E events",
        ),
        ("uncertainty of the errors", floor),
    ]
    print_list("", notes)
    print_rows(
        "Cost of features (compiled Taylor, CPU ms)",
        ("feature", "without", "with", "ratio"),
        [
            (
                feature.name,
                _milliseconds(feature.without_s),
                _milliseconds(feature.with_s),
                _ratio(feature.with_s, feature.without_s),
            )
            for feature in result.features
        ],
    )
    if result.targets:
        settings = [_cheapest_setting(result, *target) for target in result.targets.items()]
        print_list("Cheapest setting", settings)


def _cells(row: MeasuredSetting, marks: str, on_belt: bool) -> tuple[str, ...]:
    head = (row.setting.label, row.setting.text, f"{1e3 * row.cpu_s:.3g}")
    count_names = ("separations", "sticks") if on_belt else ("separations",)
    if row.error is None:
        # The failure takes the first column of errors; steps, other errors, counts and marks are
        # blank.
        blank_errors, blank_counts = [""] * (len(QUANTITIES) - 1), [""] * len(count_names)
        return (*head, "", row.failure, *blank_errors, *blank_counts, "")
    errors = (_error_text(row.error.of(name)) for name in QUANTITIES)
    counts = (f"{getattr(row.error, name):+d}" for name in count_names)
    return (*head, str(row.steps), *errors, *counts, marks)


def _error_text(value: float) -> str:
    # Switch times have an infinite error if the run misses switches of the reference, or adds some.
    return f"{value:.1e}" if math.isfinite(value) else "missed"


def _milliseconds(seconds: float | None) -> str:
    return "not finished" if seconds is None else f"{1e3 * seconds:.3f}"


def _ratio(with_s: float | None, without_s: float | None) -> str:
    return "" if with_s is None or without_s is None else f"{with_s / without_s:.2f}"


def _cheapest_setting(result: Tradeoff, quantity: str, error: float) -> tuple[str, str]:
    row = cheapest(result.rows, quantity, error)
    target = f"{quantity} to {error:g}"
    if row is None or row.error is None:
        return target, "not reached by these settings; try --thorough"
    text = f"error {row.error.of(quantity):.1e}, {number(1e3 * row.cpu_s, 3)} ms"
    return target, f"{row.setting.label}, {row.setting.text}: {text}"

"""Console output of a sweep: rows on stdout, progress on stderr.

A member is one computed parameter set, a row of the sweep.
"""

import time
from typing import Any, Final

from rich.console import Console

from fivtui.console import ProgressBar, number, print_rows

from .run import Sweep
from .study import DEFAULT_OUTPUTS, ERROR_COLUMNS, SweepColumn

# Interval of the progress lines if stderr is not a terminal.
_LINE_INTERVAL_S: Final = 30.0
# Outputs printed by default, and the number of rows printed from each end of a long sweep.
_PRINTED_OUTPUTS: Final = ("y_abs", "y_half_range", "separations", "separated_time")
_END_ROWS: Final = 20
# Units of the time left and their lengths, s, the longest first.
_UNITS_OF_TIME: Final = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"))


class SweepProgress(ProgressBar):
    """Progress of a sweep on stderr: members done, rate and time left."""

    def __init__(self, members: int) -> None:
        super().__init__("", remaining=False)
        self._members = members
        self._console = Console(stderr=True, highlight=False)
        # Time, s, and fraction done at the first call: they are the origin of the rate.
        self._start: tuple[float, float] | None = None
        # Time of the last printed line, s.
        self._printed_s = time.monotonic()

    def __call__(self, fraction: float) -> bool:
        """Show the fraction done, 0 to 1; always returns True."""
        time_s = time.monotonic()
        if self._start is None:
            # The rate does not count members that an earlier run stored.
            self._start = (time_s, fraction)
        start_s, start_fraction = self._start
        text = progress_text(self._members, fraction, fraction - start_fraction, time_s - start_s)
        self._display(fraction, text, time_s)
        return True

    def _display(self, fraction: float, text: str, time_s: float) -> None:
        if self._console.is_terminal:
            self.show(fraction, text)
        elif time_s - self._printed_s >= _LINE_INTERVAL_S:
            self._printed_s = time_s
            self._console.print(f"fivtui: {text}", soft_wrap=True)


def progress_text(members: int, fraction: float, new_fraction: float, elapsed_s: float) -> str:
    """Members done, rate and time left, if `new_fraction` took `elapsed_s` s to compute."""
    text = f"{round(fraction * members)} of {members} members ({fraction:.1%})"
    if new_fraction <= 0.0 or elapsed_s <= 0.0:
        return text
    rate = new_fraction * members / elapsed_s
    return f"{text}, {number(rate, 3)}/s, {_duration((1.0 - fraction) * members / rate)} left"


def _duration(seconds: float) -> str:
    for size, unit in _UNITS_OF_TIME:
        if seconds >= size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s"


def print_sweep(result: Sweep) -> None:
    """Print the first and last rows of a sweep with its main outputs, or those that were chosen."""
    study, rows = result.study, result.rows
    outputs_are_chosen = study.outputs != DEFAULT_OUTPUTS
    columns = [
        (index, column)
        for index, column in enumerate(study.columns)
        if outputs_are_chosen or column.name not in study.outputs or column.name in _PRINTED_OUTPUTS
        if column.name != "reason" or any(row[index] for row in rows)
    ]
    printed = rows if len(rows) <= 2 * _END_ROWS else [*rows[:_END_ROWS], *rows[-_END_ROWS:]]
    cells = [[_cell(row[index], column) for index, column in columns] for row in printed]
    header = [
        f"{column.name} ({column.unit})" if column.unit else column.name for _, column in columns
    ]
    # The varied quantities and the case identify a row.
    keys = len(study.design.axes) + 1
    print_rows(f"Sweep: {len(rows)} members", header, cells, keys=keys)
    remarks = [_fast_belt_text(result, case) for case in study.cases]
    if len(printed) < len(rows):
        remarks.append(
            f"only the first and last {_END_ROWS} rows are printed; --out and --json give all"
        )
    for text in filter(None, remarks):
        Console(stderr=True, highlight=False).print(text, soft_wrap=True)


def _fast_belt_text(result: Sweep, case: bool) -> str:
    # The belt speed from which on the belt is always faster than the slider, empty without one.
    row = result.fast_belt(case)
    output = next((name for name in _PRINTED_OUTPUTS if name in result.study.outputs), None)
    if row is None or output is None:
        return ""
    numbers = result.table.numbers
    return (
        f"from v_belt = {number(numbers['v_belt'][row], 6)} m/s on the belt is always faster than "
        f"the slider: {output} = {number(numbers[output][row], 6)}, the same as without v_belt"
        + ("" if case else ", separation ignored")
    )


def _cell(value: Any, column: SweepColumn) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value, 2 if column in ERROR_COLUMNS.values() else 6)
    return str(value)

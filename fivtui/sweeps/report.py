"""Console output of a sweep: rows on stdout, progress on stderr.

A member is one computed parameter set, a row of the sweep. The design of a study gives the varied
values of its members, on an axis for each varied quantity. Rows can be computed in two cases, with
separation of slider and belt considered (True) and ignored (False).
"""

import time
from typing import Any, Final

from rich.console import Console

from fivtui.console import ProgressBar, number, print_rows

from .run import Sweep
from .study import DEFAULT_OUTPUTS, ERROR_COLUMNS, SAFE_MU_COLUMN, SweepColumn

# Interval of the progress lines if stderr is not a terminal.
_LINE_INTERVAL_S: Final = 30.0
# Outputs printed by default; `y_half_range` is half the range of y in the second half of a run.
_PRINTED_OUTPUTS: Final = ("y_abs", "y_half_range", "separations", "separated_time")
# Number of rows printed from each end of a long sweep.
_END_ROWS: Final = 20
# Digits of outputs and parameters, and of the columns of their errors.
_DIGITS: Final = 6
_ERROR_DIGITS: Final = 2
_SAFE_MU_REMARK: Final = (
    "safe_mu is the least μ on the branch of limit cycles from the Hopf point; fivtui stability "
    "and maps also search beside it, and may find a smaller one"
)
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
        """Show the fraction done, 0 to 1. Returns True; False would cancel the sweep."""
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
    columns = [
        (index, column)
        for index, column in enumerate(study.columns)
        if _is_printed(result, index, column.name)
    ]
    printed = rows if len(rows) <= 2 * _END_ROWS else [*rows[:_END_ROWS], *rows[-_END_ROWS:]]
    cells = [[_cell(row[index], column) for index, column in columns] for row in printed]
    header = [
        f"{column.name} ({column.unit})" if column.unit else column.name for _, column in columns
    ]
    # A row is identified by its first columns: the varied quantities, and whether separation is
    # considered.
    keys = len(study.design.axes) + 1
    print_rows(f"Sweep: {len(rows)} members", header, cells, keys=keys)
    remarks = [_fast_belt_text(result, separation=separation) for separation in study.cases]
    if SAFE_MU_COLUMN.name in study.outputs:
        remarks.append(_SAFE_MU_REMARK)
    if len(printed) < len(rows):
        remarks.append(
            f"only the first and last {_END_ROWS} rows are printed; --out and --json give all"
        )
    for text in filter(None, remarks):
        Console(stderr=True, highlight=False).print(text, soft_wrap=True)


def _is_printed(result: Sweep, index: int, name: str) -> bool:
    study = result.study
    if name == "reason":
        # Why a member failed.
        return any(row[index] for row in result.rows)
    outputs_are_chosen = study.outputs != DEFAULT_OUTPUTS
    return outputs_are_chosen or name not in study.outputs or name in _PRINTED_OUTPUTS


def _fast_belt_text(result: Sweep, *, separation: bool) -> str:
    # Says from which v_belt on the belt is always faster than the slider, and an output's value
    # there; empty without such a speed. Without v_belt the model assumes that the belt is so fast.
    row = result.fast_belt(separation)
    printed_outputs = [name for name in _PRINTED_OUTPUTS if name in result.study.outputs]
    if row is None or not printed_outputs:
        return ""
    output, numbers = printed_outputs[0], result.table.numbers
    speed, value = (number(numbers[name][row], _DIGITS) for name in ("v_belt", output))
    return (
        f"from v_belt = {speed} m/s on the belt is always faster than "
        f"the slider: {output} = {value}, the same as without v_belt"
        + ("" if separation else ", separation ignored")
    )


def _cell(value: Any, column: SweepColumn) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # ERROR_COLUMNS maps quantities to the columns of their errors.
        is_error = column in ERROR_COLUMNS.values()
        return number(value, _ERROR_DIGITS if is_error else _DIGITS)
    return str(value)

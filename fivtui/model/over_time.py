"""Parameters that change with time, by tables.

Between rows F, μ and the belt's speed are linear; springs and damping hold the value of the last
row, as tunable parameters of an FMU hold their value between changes.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from .errors import InputError
from .field import CONSTANT, Rates
from .numbers import parse_number
from .parameters import Parameters, check_known, parameter_spec

# The parameters that may change with time: linear between rows, and held from row to row.
LINEAR_OVER_TIME: Final = ("F", "mu", "v_belt")
HELD_OVER_TIME: Final = ("k1", "k2", "k3", "c1", "c2", "k_nl")
TIME_DEPENDENT: Final = (*LINEAR_OVER_TIME, *HELD_OVER_TIME)
# Largest number of rows that are all listed in a description.
_MAX_LISTED_ROWS: Final = 4
_ROWS_TEXT: Final = "pairs of time (s) and value"


@dataclass(frozen=True, slots=True)
class TimeTable:
    """Values of a parameter over time, linear between rows, constant before and after them.

    The value jumps at a time in two rows; the later row applies from that time.

    Attributes
    ----------
    times : tuple of float
        Ascending, s.
    values : tuple of float
        In the unit of the parameter.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def after(self, t: float) -> tuple[float, float]:
        """Value and slope just after a time, s."""
        index = bisect_right(self.times, t)
        if index == 0 or index == len(self.times):
            return self.values[0 if index == 0 else -1], 0.0
        (begin, end), (start_value, end_value) = self._rows_before_and_at(index)
        slope = (end_value - start_value) / (end - begin)
        value = start_value + slope * (t - begin)
        # Rounding must not take the value beyond those of the two rows.
        return min(max(value, min(start_value, end_value)), max(start_value, end_value)), slope

    def before(self, t: float) -> float:
        """Value just before a time, s; at a jump it differs from that of `after`."""
        index = bisect_left(self.times, t)
        if index < len(self.times) and self.times[index] == t:
            return self.values[index]
        return self.after(t)[0]

    def rows(self) -> list[tuple[float, float]]:
        """Pairs of time, s, and value."""
        return list(zip(self.times, self.values, strict=True))

    def describe(self, name: str) -> str:
        """Description of the table of a parameter, such as ``0 (0 s) → 80 (2 s)``."""
        rows = self.rows()
        if name in HELD_OVER_TIME:
            # Leave out the rows that `time_table` adds before jumps.
            pairs = zip(rows, [*rows[1:], (math.inf, 0.0)], strict=True)
            rows = [row for row, following in pairs if row[0] < following[0]]
        count = len(rows)
        if count <= _MAX_LISTED_ROWS:
            return " → ".join(f"{value:g} ({t:g} s)" for t, value in rows)
        span = f"{self.times[0]:g} to {self.times[-1]:g} s"
        return f"{min(self.values):g} to {max(self.values):g}, {count} rows over {span}"

    def _rows_before_and_at(self, index: int) -> tuple[tuple[float, float], tuple[float, float]]:
        pair = slice(index - 1, index + 1)
        (begin, end), (start_value, end_value) = self.times[pair], self.values[pair]
        return (begin, end), (start_value, end_value)


# A table, or pairs of time, s, and value.
Rows = TimeTable | Iterable[Sequence[float]]


def time_table(name: str, rows: Rows) -> TimeTable:
    """The checked table of a parameter from pairs of time, s, and value.

    A parameter that is held jumps at each row: the table gets a row with the value before the jump.

    Raises `InputError` if the parameter cannot change with time, times do not ascend, or a value is
    out of range.
    """
    check_known("parameter over time", name, TIME_DEPENDENT)
    spec = parameter_spec(name)
    if isinstance(rows, TimeTable):
        rows = zip(rows.times, rows.values, strict=True)
    times: list[float] = []
    values: list[float] = []
    for row in rows:
        if len(row) != 2:
            raise InputError(f"{name} over time: {row!r}: must be {_ROWS_TEXT}")
        t = parse_number(f"time of {name}", row[0], "a finite number")
        if times and t < times[-1]:
            raise InputError(f"{name} over time: {t:g} s after {times[-1]:g} s: times must ascend")
        value = spec.check(row[1])
        if times and t > times[-1] and name in HELD_OVER_TIME:
            if value != values[-1]:
                times.append(t)
                values.append(values[-1])
        elif times and t > times[-1]:
            slope = (value - values[-1]) / (t - times[-1])
            if not math.isfinite(slope):
                raise InputError(f"{name} over time: at {t:g} s: a jump needs the same time twice")
        times.append(t)
        values.append(value)
    if not times:
        raise InputError(f"{name} over time: there are no rows; must be {_ROWS_TEXT}")
    return TimeTable(tuple(times), tuple(values))


def time_tables(over_time: Mapping[str, Rows]) -> dict[str, TimeTable]:
    """The checked tables of parameters, see `time_table`."""
    return {name: time_table(name, rows) for name, rows in over_time.items()}


def initial_values(tables: Mapping[str, TimeTable]) -> dict[str, float]:
    """Values just after t = 0."""
    return {name: table.after(0.0)[0] for name, table in tables.items()}


@dataclass(frozen=True, slots=True)
class Course:
    """Parameters as functions of time: `tables` override values of the constant set `fixed`.

    Raises `InputError` if μ exceeds `mu_s` at some time.
    """

    fixed: Parameters
    tables: Mapping[str, TimeTable]

    def __post_init__(self) -> None:
        mu_max = max(self.tables["mu"].values) if "mu" in self.tables else self.fixed.mu
        if self.fixed.mu_s is not None and mu_max > self.fixed.mu_s:
            raise InputError(
                f"mu over time: reaches {mu_max:g}: must be at most mu_s = {self.fixed.mu_s:g}"
            )

    def after(self, t: float) -> tuple[Parameters, Rates]:
        """The parameters just after a time, s, and their rates of change."""
        if not self.tables:
            return self.fixed, CONSTANT
        rows = {name: table.after(t) for name, table in self.tables.items()}
        values = {name: value for name, (value, _) in rows.items()}
        slopes: dict[str, float] = {
            name: rows[name][1] for name in LINEAR_OVER_TIME if name in rows
        }
        # Without `mu_s` the static coefficient `mu_static` is μ.
        if "mu" in slopes and self.fixed.mu_s is None:
            slopes["mu_static"] = slopes["mu"]
        return self.fixed.with_inputs(values), Rates(**slopes)

    @property
    def initial(self) -> Parameters:
        """The parameters just after t = 0."""
        return self.fixed.with_values(initial_values(self.tables))

    def speed_before(self, t: float) -> float:
        """Speed of the belt just before a time, m/s; 0 for a belt without finite speed."""
        table = self.tables.get("v_belt")
        return (self.fixed.v_belt or 0.0) if table is None else table.before(t)

    def next_row_time(self, t: float) -> float:
        """The next time, s, at which a table has a row; infinite after the last one."""
        row_times = (
            table.times[index]
            for table in self.tables.values()
            if (index := bisect_right(table.times, t)) < len(table.times)
        )
        return min(row_times, default=math.inf)

    def row_times_before(self, t_end: float) -> list[float]:
        """The times of all rows between 0 and a horizon, s, ascending."""
        times = {t for table in self.tables.values() for t in table.times}
        return sorted(t for t in times if 0.0 < t < t_end)

    @property
    def greatest_load(self) -> float:
        """Greatest |F| at any time, N."""
        table = self.tables.get("F")
        return abs(self.fixed.F) if table is None else max(map(abs, table.values))


def parameters_after(p: Parameters, rates: Rates, duration: float) -> Parameters:
    """The parameters after a duration, s, over which they change at constant rates."""
    if rates == CONSTANT:
        return p
    values = {"F": p.F + rates.F * duration, "mu": max(p.mu + rates.mu * duration, 0.0)}
    if p.v_belt is not None:
        values["v_belt"] = p.v_belt + rates.v_belt * duration
    # Not `with_values`, whose checks may fail where rounding takes a value beyond its bounds.
    return p.replaced(**values)


def build_course(p: Parameters, over_time: Mapping[str, Rows]) -> Course:
    """Parameters as functions of time, checked; raises `InputError` if a table is invalid."""
    return Course(p, time_tables(over_time))

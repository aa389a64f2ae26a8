"""The result of a batch: arrays with one element per member, and errors of failed members."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import Status
from fivtui.model import (
    ALL_PARAMETERS,
    Column,
    ComputationError,
    InputError,
    Parameters,
    System,
    no_equilibrium_error,
)
from fivtui.results import Comparable, Result, Table, Tabular, to_data
from fivtui.taylor import overflow_error, stall_error
from fivtui.transient import max_steps_error

Floats = NDArray[np.float64]
# Columns of batches by name; `fivtui.sweeps` also takes units and meanings from here.
BATCH_COLUMNS: Final[Mapping[str, Column]] = {
    column.name: column
    for column in (
        Column("status", "", "how the integration ended"),
        Column("t", "s", "time reached"),
        Column("steps", "", "integration steps"),
        Column("y_abs", "m", "peak of |y|"),
        Column("y_max", "m", "greatest y"),
        Column("y_min", "m", "least y"),
        Column("x_abs", "m", "peak of |x|"),
        # Without v_belt a run is valid only for a belt that is faster than the slider.
        Column("vx_max", "m/s", "least valid belt speed"),
        Column("y_half_range", "m", "half peak-to-peak of y, second half"),
        Column("separations", "", "number of separations"),
        Column("reattachments", "", "number of reattachments"),
        Column("separated_time", "s", "time off the belt"),
        Column("first_switch", "s", "time of the first switch"),
        Column("last_switch", "s", "time of the last switch"),
        Column("x_end", "m", "horizontal displacement at the end"),
        Column("vx_end", "m/s", "horizontal velocity at the end"),
        Column("y_end", "m", "vertical displacement at the end"),
        Column("vy_end", "m/s", "vertical velocity at the end"),
    )
}
# Columns of the failures of a batch: index of the member, last state, whether separation is
# considered, and parameters, NaN if not used.
FAILURE_COLUMNS: Final = ("member", "x", "vx", "y", "vy", "separation", *ALL_PARAMETERS)
# Attributes of `BatchEvents` whose columns have another name.
_EVENT_COLUMNS: Final = {"first": "first_switch", "last": "last_switch"}


@dataclass(frozen=True, slots=True, eq=False)
class BatchAmplitude(Comparable):
    """Extremes of y over the whole runs, not sampled, m, shape (n,) each."""

    y_abs: Floats
    y_max: Floats
    y_min: Floats


@dataclass(frozen=True, slots=True, eq=False)
class BatchPeak(BatchAmplitude):
    """Extremes of x, y (m) and ẋ (m/s), not sampled, as `Peak`, shape (n,) each."""

    x_abs: Floats
    vx_max: Floats


@dataclass(frozen=True, slots=True, eq=False)
class BatchSteady(Comparable):
    """Half peak-to-peak of y over the second half of the run, m, shape (n,)."""

    y_half_range: Floats


@dataclass(frozen=True, slots=True, eq=False)
class BatchEvents(Comparable):
    """Switches of the runs, shape (n,) each.

    Attributes
    ----------
    separations, reattachments : ndarray of int64
        Numbers of separations and reattachments; -1 for a member that failed.
    separated_time : ndarray
        Time off the belt, s.
    first, last : ndarray
        Time of the first and last switch, s; NaN for a run without switches.
    """

    separations: NDArray[np.int64]
    reattachments: NDArray[np.int64]
    separated_time: Floats
    first: Floats
    last: Floats


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Batch(Result, Tabular):
    """Result of a batch of n transients; values of members that failed are NaN.

    Reading a result that was not required raises `InputError`.

    Attributes
    ----------
    t_end : float
        Horizon, s.
    tol : float
        Relative tolerance.
    status : ndarray of int8, shape (n,)
        How the integration of each member ended, a `Status`.
    t : ndarray, shape (n,)
        Time reached, s: the horizon unless the member failed.
    steps : ndarray of int64, shape (n,)
        Integration steps.
    """

    t_end: float
    tol: float
    status: NDArray[np.int8]
    t: Floats
    steps: NDArray[np.int64]
    # The required results by name.
    _parts: Mapping[str, Any] = field(repr=False)
    # A row of `FAILURE_COLUMNS` for each member that failed, in ascending order of members.
    _failures: Floats = field(repr=False)

    @property
    def final(self) -> Floats:
        """States (x, ẋ, y, ẏ) at the horizon, m and m/s, shape (n, 4)."""
        return cast("Floats", self._required("final"))

    @property
    def amplitude(self) -> BatchAmplitude:
        """Extremes of y over the whole runs."""
        return cast("BatchAmplitude", self._required("amplitude"))

    @property
    def peak(self) -> BatchPeak:
        """Extremes over the whole runs."""
        return cast("BatchPeak", self._required("peak"))

    @property
    def steady(self) -> BatchSteady:
        """Half peak-to-peak over the second half of the run."""
        return cast("BatchSteady", self._required("steady"))

    @property
    def events(self) -> BatchEvents:
        """Switches."""
        return cast("BatchEvents", self._required("events"))

    def _required(self, name: str) -> Any:
        # A part of the results; `InputError` if it was not computed.
        if name not in self._parts:
            raise InputError(f"{name}: not required of this batch; add it to require")
        return self._parts[name]

    @property
    def failed(self) -> NDArray[np.int64]:
        """The members that failed, in ascending order."""
        return self._failures[:, FAILURE_COLUMNS.index("member")].astype(np.int64)

    def failure(self, member: int) -> ComputationError | None:
        """The error of a member, counted from 0 or backwards from -1; None if it did not fail."""
        status, t = Status(self.status[member]), float(self.t[member])
        if status is Status.DONE:
            return None
        row = np.searchsorted(self.failed, member % self.status.size)
        _, x, vx, y, vy, separation, *values = self._failures[row].tolist()
        used = {
            name: value
            for name, value in zip(ALL_PARAMETERS, values, strict=True)
            if not math.isnan(value)
        }
        p = Parameters().with_values(used)
        if status is Status.OVERFLOW:
            return overflow_error(t, (x, vx, y, vy), System(p, separation=bool(separation)))
        if status is Status.STALLED:
            return stall_error(t, p)
        if status is Status.STEP_LIMIT:
            return max_steps_error(int(self.steps[member]), t, self.t_end, tol=self.tol)
        return no_equilibrium_error(p.F)

    def _summary(self) -> list[tuple[str, str]]:
        rows = [
            ("members", f"{self.status.size}, {self.failed.size} failed"),
            ("run", f"{self.t_end:g} s, tol {self.tol:g}, {int(self.steps.sum())} steps"),
        ]
        for name in ("y_abs", "y_half_range", "separations"):
            values = self.to_columns().get(name)
            done_values = np.empty(0) if values is None else values[self.status == Status.DONE]
            if done_values.size:
                rows.append((name, f"{done_values.min():.6g} to {done_values.max():.6g}"))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """Horizon, tolerance and the columns as lists; None replaces NaN."""
        return {"t_end": self.t_end, "tol": self.tol, "columns": to_data(self.to_columns())}

    def _table(self) -> Table:
        return {BATCH_COLUMNS[name]: values for name, values in self._named_values()}

    def _named_values(self) -> Iterator[tuple[str, NDArray[Any]]]:
        # Name and values of every computed column.
        yield from (("status", self.status), ("t", self.t), ("steps", self.steps))
        for name, part in self._parts.items():
            if name == "final":
                states = zip(("x_end", "vx_end", "y_end", "vy_end"), part.T, strict=True)
                yield from ((column, values.copy()) for column, values in states)
            else:
                for item in fields(part):
                    yield _EVENT_COLUMNS.get(item.name, item.name), getattr(part, item.name)


# Functions that allocate the results for n members, by the name of the requirement.
ALLOCATORS: Final[Mapping[str, Callable[[int], Any]]] = {
    "final": lambda n: np.empty((n, 4)),
    "amplitude": lambda n: BatchAmplitude(*(np.empty(n) for _ in range(3))),
    "peak": lambda n: BatchPeak(*(np.empty(n) for _ in range(5))),
    "steady": lambda n: BatchSteady(np.empty(n)),
    "events": lambda n: BatchEvents(
        np.empty(n, np.int64), np.empty(n, np.int64), *(np.empty(n) for _ in range(3))
    ),
}

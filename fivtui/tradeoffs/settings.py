"""Settings of the methods, with measured errors and CPU times, and the choice of the best.

The setting of a method is its tolerance or its step. A ladder has the settings to be measured.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from fivtui.transient import Deviation, check_quantity


@dataclass(frozen=True, slots=True)
class Setting:
    """A method with a value of its setting.

    Attributes
    ----------
    method : str
        Name of the method.
    kernel : str
        ``"compiled"`` or ``"interpreted"`` for a method that has both, else empty.
    knob : str
        ``"tol"`` or ``"step"``.
    value : float
        Relative tolerance, or step in s.
    """

    method: str
    kernel: str
    knob: str
    value: float

    @property
    def label(self) -> str:
        """The method, with its kernel if it has two."""
        return f"{self.method} ({self.kernel})" if self.kernel else self.method

    @property
    def text(self) -> str:
        """The setting as on the command line, such as ``tol=1e-06``."""
        return f"{self.knob}={self.value:g}"


@dataclass(frozen=True, slots=True)
class MeasuredSetting:
    """A measured setting.

    Attributes
    ----------
    setting : Setting
        The setting of the run.
    cpu_s : float
        CPU time of one run, s, also if it did not finish.
    steps : int
        Integration steps; communication steps for the FMU.
    error : Deviation or None
        Errors against the reference; None if the run did not finish.
    failure : str
        Why the run did not finish; empty if it did.
    """

    setting: Setting
    cpu_s: float
    steps: int
    error: Deviation | None
    failure: str = ""


@dataclass(frozen=True, slots=True)
class Ladder:
    """The settings of a method: from `coarsest` to `finest` in ratios of `factor`."""

    method: str
    kernel: str
    knob: str
    coarsest: float
    finest: float
    factor: float

    def settings(self) -> Iterator[Setting]:
        """The settings, coarsest first."""
        count = 1 + round(math.log(self.finest / self.coarsest) / math.log(self.factor))
        for number in range(count):
            value = float(f"{self.coarsest * self.factor**number:.6g}")
            yield Setting(self.method, self.kernel, self.knob, value)


# Method, kernel, coarsest and finest tolerance, ratio of one tolerance to the one before.
_TOLERANCES: Final = (
    ("taylor", "compiled", 1e-2, 1e-13, 0.1),
    ("taylor", "interpreted", 1e-3, 1e-12, 1e-3),
    ("scipy-dop853", "", 1e-3, 1e-12, 1e-3),
    ("scipy-lsoda", "", 1e-3, 1e-12, 1e-3),
    ("scipy-radau", "", 1e-3, 1e-9, 1e-2),
)
# Method, coarsest and finest step in units of √(m/(k1 + k2 + k3)), ratio of one step to the one
# before. The method rk4 locates every switch by bisection, rk4-across steps across switches.
_STEPS: Final = (
    ("rk4", 0.4, 0.4 / 2.0**9, 0.5),
    ("rk4-across", 0.4, 0.4 / 2.0**9, 0.5),
    ("fmu", 1.0, 1.0 / 4.0**5, 0.25),
    ("fmu-native", 1.0, 1.0 / 4.0**5, 0.25),
)


def ladders(time_scale: float, t_end: float) -> list[Ladder]:
    """The settings to measure, a ladder for each method and kernel.

    Fixed steps are multiples of `time_scale`, √(m/(k1 + k2 + k3)) in s, and at most `t_end`.
    """
    result = [Ladder(method, kernel, "tol", *values) for method, kernel, *values in _TOLERANCES]
    for method, coarsest, finest, factor in _STEPS:
        first_step = min(coarsest * time_scale, t_end)
        last_step = first_step * finest / coarsest
        result.append(Ladder(method, "", "step", first_step, last_step, factor))
    return result


def pareto_front(
    rows: Iterable[MeasuredSetting], quantity: str, floor: float = 0.0
) -> list[MeasuredSetting]:
    """The settings that no other setting beats in both CPU time and error, cheapest first.

    `quantity` is that of the error; errors below `floor` count as `floor`.
    """
    check_quantity(quantity)
    finished = [
        (row.cpu_s, max(row.error.of(quantity), floor), row)
        for row in rows
        if row.error is not None
    ]
    front: list[MeasuredSetting] = []
    least_error = math.inf
    for _, error, row in sorted(finished, key=lambda entry: entry[:2]):
        if error < least_error:
            front.append(row)
            least_error = error
    return front


def cheapest(
    rows: Sequence[MeasuredSetting], quantity: str, error: float
) -> MeasuredSetting | None:
    """The setting of least CPU time with an error of at most `error`; None if there is none.

    `quantity` is a name in `QUANTITIES`; `InputError` if it is unknown.
    """
    return next(
        (row for row in pareto_front(rows, quantity) if _error(row, quantity) <= error), None
    )


def _error(row: MeasuredSetting, quantity: str) -> float:
    return math.inf if row.error is None else row.error.of(quantity)

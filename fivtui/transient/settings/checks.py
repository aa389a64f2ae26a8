"""Checks of the settings of a transient: start, horizon, tolerance, step, allowed errors."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Final, Literal

from fivtui.model import (
    ALL_PARAMETERS,
    InputError,
    Interval,
    ParameterSpec,
    State,
    check_known,
    parse_number,
)

# A start: at rest at the equilibrium for μ = 0, or the state (x, ẋ, y, ẏ) in m and m/s.
Start = Literal["static"] | Sequence[float]

# Largest magnitude of a number of a start, m or m/s.
_MAX_START: Final = 1e9


def _start_spec(name: str, symbol: str, unit: str, meaning: str) -> ParameterSpec:
    return ParameterSpec(name, symbol, unit, 0.0, -_MAX_START, _MAX_START, meaning)


# Specifications of the four numbers of a start, in the order of a state.
START_SPECS: Final[Mapping[str, ParameterSpec]] = {
    spec.name: spec
    for spec in (
        _start_spec("x0", "x_0", "m", "horizontal displacement at the start"),
        _start_spec("vx0", "vx_0", "m/s", "horizontal velocity at the start"),
        _start_spec("y0", "y_0", "m", "vertical displacement at the start"),
        _start_spec("vy0", "vy_0", "m/s", "vertical velocity at the start"),
    )
}
# Quantities that studies vary: parameters and components of the start.
VARIABLES: Final[Mapping[str, ParameterSpec]] = {**ALL_PARAMETERS, **START_SPECS}
STATIC: Final = "static"
# Components of a start below this size are set to zero: their products would underflow.
START_THRESHOLD: Final = 1e-150
# Default and greatest horizon, s.
DEFAULT_T_END: Final = 100.0
MAX_T_END: Final = 1e7
T_END_INTERVAL: Final = Interval(0.0, MAX_T_END, "s", lower_open=True)
START_TEXT: Final = "static, or four finite numbers x,vx,y,vy in m and m/s"
# The quantities whose error can be limited, with their meaning and how the error is measured.
QUANTITIES: Final[Mapping[str, str]] = {
    "final": "state at the end, relative to its greatest component",
    "peak": "peak of |y|, relative",
    "half_range": "half peak-to-peak of y over the second half of the run, relative to peak |y|",
    "events": "times of separation and reattachment, s",
}
# Settings that follow from the allowed errors of a scene, its `accuracy`.
SET_BY_ACCURACY: Final = ("tol", "step")
_ERROR_INTERVAL: Final = Interval(0.0, 1.0, lower_open=True)


def check_start(start: Start) -> Literal["static"] | State:
    """A start as numbers, or ``"static"``; raises `InputError` for any other value."""
    if isinstance(start, str):
        if start == STATIC:
            return STATIC
        raise InputError(f"start = {start!r}: must be {START_TEXT}")
    try:
        values = list(start)
    except TypeError:
        values = []
    if len(values) != len(START_SPECS):
        raise InputError(f"start = {start!r}: must be {START_TEXT}")
    numbers = (parse_number("start", value, START_TEXT) for value in values)
    x, vx, y, vy = (0.0 if abs(number) < START_THRESHOLD else number for number in numbers)
    return (x, vx, y, vy)


def check_horizon(t_end: float | str) -> float:
    """A horizon in s, as number or text; raises `InputError` unless 0 < t_end <= 1e7."""
    return T_END_INTERVAL.check("t_end", t_end)


def check_tolerance(tol: float | str) -> float:
    """A relative tolerance, as number or text; raises `InputError` if out of range."""
    return tolerance_interval().check("tol", tol)


@cache
def tolerance_interval() -> Interval:
    """The range of a relative tolerance."""
    from fivtui.taylor import TOL_RANGE

    return Interval(*TOL_RANGE)


def check_step(step: float | str, t_end: float) -> float:
    """A step in s, as number or text; raises `InputError` unless 0 < step <= t_end."""
    return Interval(0.0, t_end, "s", lower_open=True).check("step", step)


def check_quantity(name: str) -> str:
    """The name of a quantity in `QUANTITIES`; raises `InputError` if it is unknown."""
    check_known("quantity", name, QUANTITIES)
    return name


def check_accuracy(errors: Mapping[str, object]) -> dict[str, float]:
    """The allowed error of each quantity; raises `InputError` unless above 0 and at most 1."""
    return {
        check_quantity(name): _ERROR_INTERVAL.check(f"error of {name}", error)
        for name, error in errors.items()
    }

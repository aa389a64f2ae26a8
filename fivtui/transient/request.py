"""What is asked of a transient, checked: start, horizon, tolerance, step."""

from collections.abc import Mapping, Sequence
from typing import Final, Literal

import numpy as np

from fivtui.model import (
    InputError,
    Interval,
    Parameters,
    ParameterSpec,
    State,
    check_parameters,
    parse_number,
    static_start,
)
from fivtui.taylor import DEFAULT_TOL as TAYLOR_TOL, TOL_RANGE as TAYLOR_TOL_RANGE

from .methods import Problem

Start = Literal["static"] | Sequence[float]

_START_MAX: Final = 1e9


def _start_spec(name: str, symbol: str, unit: str, meaning: str) -> ParameterSpec:
    return ParameterSpec(name, symbol, unit, 0.0, -_START_MAX, _START_MAX, False, meaning)


# The four numbers of a start, in the order of a state.
START_SPECS: Final[Mapping[str, ParameterSpec]] = {
    spec.name: spec
    for spec in (
        _start_spec("x0", "x_0", "m", "horizontal displacement at the start"),
        _start_spec("vx0", "vx_0", "m/s", "horizontal velocity at the start"),
        _start_spec("y0", "y_0", "m", "vertical displacement at the start"),
        _start_spec("vy0", "vy_0", "m/s", "vertical velocity at the start"),
    )
}

# Smaller components of a start are zero: their products would underflow.
LEAST_START: Final = 1e-150
DEFAULT_T_END: Final = 100.0
DEFAULT_TOL: Final = TAYLOR_TOL
MAX_T_END: Final = 1e7
TOL_RANGE: Final = TAYLOR_TOL_RANGE
T_END_INTERVAL: Final = Interval(0.0, MAX_T_END, "s", lower_open=True)
TOL_INTERVAL: Final = Interval(*TOL_RANGE)
START_FORM: Final = "static, or four finite numbers x,vx,y,vy in m and m/s"


def resolve_start(p: Parameters, start: Start, *, separation: bool) -> State:
    """The start state in numbers.

    Parameters
    ----------
    p : Parameters
        The parameter set.
    start : "static" or sequence of four floats
        At rest at the equilibrium of μ = 0, or (x, ẋ, y, ẏ) in m and m/s; less than 1e-150 is zero.
    separation : bool
        Whether separation is considered.

    Returns
    -------
    State
        (x, ẋ, y, ẏ).

    Raises
    ------
    InputError
        If `start` is neither.
    """
    if isinstance(start, str) and start == "static":
        return static_start(p, separation=separation)
    if isinstance(start, str):
        raise InputError(f"start = {start!r}: must be {START_FORM}")
    given = np.asarray(start)
    if given.shape != (4,):
        raise InputError(f"start = {start!r}: must be {START_FORM}")
    numbers = (parse_number("start", value, START_FORM) for value in given.tolist())
    x, vx, y, vy = (0.0 if abs(number) < LEAST_START else number for number in numbers)
    return (x, vx, y, vy)


def check_horizon(t_end: float | str) -> float:
    """Check a horizon.

    Parameters
    ----------
    t_end : float or str
        Horizon, s; text that reads as a number will do.

    Returns
    -------
    float
        The horizon, s.

    Raises
    ------
    InputError
        If it is not in 0 < t_end <= 1e7 s.
    """
    return T_END_INTERVAL.check("t_end", t_end)


def check_tolerance(tol: float | str) -> float:
    """Check a relative tolerance.

    Parameters
    ----------
    tol : float or str
        The tolerance; text that reads as a number will do.

    Returns
    -------
    float
        The tolerance.

    Raises
    ------
    InputError
        If it is not in `TOL_RANGE`.
    """
    return TOL_INTERVAL.check("tol", tol)


def make_problem(
    p: Parameters,
    *,
    t_end: float = DEFAULT_T_END,
    tol: float = DEFAULT_TOL,
    separation: bool = True,
    start: Start = "static",
    step: float | None = None,
) -> Problem:
    """Check a request for a transient.

    Parameters
    ----------
    p, t_end, tol, separation, start, step
        As in `integrate`.

    Returns
    -------
    Problem
        Ready to be integrated.

    Raises
    ------
    InputError
        If a value is out of range, or `p` is no parameter set.
    """
    check_parameters(p)
    t_end = check_horizon(t_end)
    tol = check_tolerance(tol)
    if step is not None:
        step = Interval(0.0, t_end, "s", lower_open=True).check("step", step)
    return Problem(p, resolve_start(p, start, separation=separation), t_end, separation, tol, step)

"""Check and convert the arguments of a batch: parameter sets, start states, separation.

A member is one transient of the batch; arrays have a row or an element per member.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fivtui.model import ALL_PARAMETERS, PARAMETERS, InputError, Parameters, parameter_spec
from fivtui.transient import START_THRESHOLD

from .result import Floats


def member_columns(
    parameters: Mapping[str, ArrayLike] | ArrayLike, base: Parameters
) -> tuple[dict[str, Floats], int]:
    """The columns of parameters by name, without copies, and the number of members.

    There are nine columns, and more if the belt has a finite speed. `parameters` is as in
    `simulate_batch`; `base` has the values that a mapping does not name. Raises `InputError` if a
    name, a shape or a value is wrong.
    """
    if isinstance(parameters, Mapping):
        named = {name: _numbers(name, value) for name, value in parameters.items()}
        for name in named:
            parameter_spec(name)
        try:
            shape = np.broadcast_shapes((1,), *(column.shape for column in named.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {column.shape}" for name, column in named.items())
            raise InputError(f"parameters: shapes do not fit each other ({shapes})") from None
        if len(shape) != 1:
            raise InputError(f"parameters: shape {shape}; must have one axis")
        values = {name: np.asarray(value) for name, value in base.as_dict().items()} | named
        # Without v_belt, the parameters mu_s and v_s have no effect: those of `base` are dropped,
        # those that the caller names are refused by `_check_belt`.
        used = ALL_PARAMETERS if "v_belt" in values else {**PARAMETERS, **named}
        names = [name for name in ALL_PARAMETERS if name in values and name in used]
        columns = {name: np.broadcast_to(values[name], shape) for name in names}
    else:
        table = _numbers("parameters", parameters)
        if table.ndim != 2 or table.shape[1] != len(PARAMETERS):
            raise InputError(
                f"parameters: shape {table.shape}; must be (n, {len(PARAMETERS)}), "
                f"columns {', '.join(PARAMETERS)}"
            )
        columns = dict(zip(PARAMETERS, table.T, strict=True))
    size = next(iter(columns.values())).size
    if size > 0:
        for name, column in columns.items():
            _check_column(name, column)
    _check_belt(columns)
    return columns, size


def belt_rows(columns: Mapping[str, Floats]) -> Floats | None:
    """v_belt, μ_s and v_s of members, shape (n, 3).

    v_s is the sliding speed over which friction falls from μ_s to μ; 0 where friction is constant.
    None without v_belt: the belt is then always faster than the slider.
    """
    if "v_belt" not in columns:
        return None
    mu_s = columns.get("mu_s", columns["mu"])
    v_s = np.where(mu_s > columns["mu"], columns.get("v_s", 0.0), 0.0)
    return np.column_stack([columns["v_belt"], mu_s, v_s])


def falling_friction(belts: Floats) -> NDArray[np.bool_]:
    """Whether friction falls with the sliding speed, from the rows of `belt_rows`, shape (n,)."""
    _, _, v_s = belts.T
    return np.asarray(v_s > 0.0)


def _check_belt(columns: Mapping[str, Floats]) -> None:
    for name in ("mu_s", "v_s"):
        if name in columns and "v_belt" not in columns:
            raise InputError(f"{name} has no effect without v_belt, which must be given")
    if "mu_s" in columns and (columns["mu_s"] < columns["mu"]).any():
        member = int(np.argmax(columns["mu_s"] < columns["mu"]))
        mu, mu_s = float(columns["mu"][member]), float(columns["mu_s"][member])
        raise InputError(f"member {member}: mu_s = {mu_s:g}: must be at least mu = {mu:g}")


def _numbers(name: str, value: ArrayLike) -> Floats:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: not an array of numbers") from None


def _check_column(name: str, column: Floats) -> None:
    # It is enough to check the least and greatest value: both are NaN if any value is.
    spec = parameter_spec(name)
    try:
        spec.check(float(column.min()))
        spec.check(float(column.max()))
    except InputError:
        for member, value in enumerate(column.tolist()):
            try:
                spec.check(value)
            except InputError as error:
                raise InputError(f"member {member}: {error}") from None


def separation_flags(separation: ArrayLike, size: int) -> NDArray[np.bool_]:
    """Whether each member considers separation, shape (n,); do not write to the array."""
    values = np.asarray(separation)
    if values.dtype != np.bool_ or values.shape not in ((), (size,)):
        raise InputError(f"separation: must be a bool, or an array of {size}")
    return np.broadcast_to(values, (size,))


def start_states(start: ArrayLike, size: int) -> Floats | None:
    """The start states, shape (n, 4), not to be written to; None for static starts.

    Raises `InputError` if the shape is wrong or a value is not finite.
    """
    if isinstance(start, str) and start == "static":
        return None
    allowed = f"must be static, or finite numbers x,vx,y,vy, shape (4,) or ({size}, 4)"
    try:
        states = np.asarray(start, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"start = {start!r}: {allowed}") from None
    if states.shape not in ((4,), (size, 4)):
        raise InputError(f"start: shape {states.shape}; {allowed}")
    if states.size > 0 and not np.isfinite([states.min(), states.max()]).all():
        raise InputError(f"start: not all finite; {allowed}")
    # Products of smaller components would underflow.
    states = np.where(np.abs(states) < START_THRESHOLD, 0.0, states)
    return np.broadcast_to(states, (size, 4))

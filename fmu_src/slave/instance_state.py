"""The state of an FMU instance as one immutable value, and as bytes."""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fivtui.model.errors import InputError
from fivtui.taylor.stepper import TOL_RANGE

from .experiment import Experiment
from .variable import VariableTable

# The build of the FMU: the bundled package is named by a hash of its content.
_BUILD: Final = __name__.partition(".")[0]
DAMAGED: Final = "the serialised FMU state is damaged"


class Phase(StrEnum):
    """Phase of an instance in the calling sequence of FMI 2.0; values are words for messages."""

    INSTANTIATED = "before initialization"
    INITIALIZATION = "in initialization mode"
    STEPPING = "while stepping"
    TERMINATED = "after termination"


class InstanceState(NamedTuple):
    """The complete state of an FMU instance: phase, experiment, values of all variables, motion.

    `experiment` is None before it is set up, `motion_state` before the motion begins.
    """

    phase: Phase
    experiment: Experiment | None
    values: tuple[float | bool, ...]
    motion_state: Any


def to_bytes(state: InstanceState, to_json: Callable[[Any], Any]) -> bytes:
    """Serialise a state: a checksum and JSON, from which floats read back bit for bit."""
    # Imported when used: a host's search path may hide what few hosts need.
    import json
    import zlib

    motion_state = None if state.motion_state is None else to_json(state.motion_state)
    text = json.dumps({"build": _BUILD, **state._asdict(), "motion_state": motion_state}).encode()
    return b"%08x" % zlib.crc32(text) + text


def from_bytes(data: bytes, table: VariableTable, from_json: Callable[[Any], Any]) -> InstanceState:
    """Read a state of an instance with these variables, written by `to_bytes`.

    Raises `InputError` if the bytes are damaged or come from another build of the FMU.
    """
    import json
    import zlib

    checksum, text = data[:8], data[8:]
    if checksum != b"%08x" % zlib.crc32(text):
        raise InputError(DAMAGED)
    try:
        content = json.loads(text)
        build = content.pop("build")
        state = _read(content, table, from_json) if build == _BUILD else None
    except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(DAMAGED) from error
    if state is None:
        raise InputError("the serialised FMU state comes from another build of this FMU")
    return state


def _read(content: Any, table: VariableTable, from_json: Callable[[Any], Any]) -> InstanceState:
    # Raises one of many errors where it is not that of a state.
    motion_state, experiment, values = (
        content[name] for name in ("motion_state", "experiment", "values")
    )
    phase = Phase(content["phase"])
    if not (_all_finite(motion_state) and len(values) == len(table.variables)):
        raise ValueError
    if phase is Phase.STEPPING and None in (motion_state, experiment):
        raise ValueError
    for reference, (variable, value) in enumerate(zip(table.variables, values, strict=True)):
        if variable.settable:
            table.check_settable(reference, variable.type, value)
        elif not isinstance(value, int | float):
            raise TypeError
    return InstanceState(
        phase,
        None if experiment is None else _experiment(*experiment),
        tuple(values),
        None if motion_state is None else from_json(motion_state),
    )


def number(value: object) -> Any:
    """A number of JSON as it is; `TypeError` if it is something else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    return value


def numbers(values: Any, count: int) -> tuple[Any, ...]:
    """So many numbers of a list of JSON; `ValueError` or `TypeError` if it is something else."""
    if len(values) != count:
        raise ValueError
    return tuple(map(number, values))


def _experiment(start: float, stop: float, tol: float) -> Experiment:
    lowest, highest = TOL_RANGE
    if not (math.isfinite(start) and stop >= start and lowest <= tol <= highest):
        raise ValueError
    return Experiment(start, stop, tol)


def _all_finite(content: Any) -> bool:
    if isinstance(content, dict | list):
        return all(map(_all_finite, content.values() if isinstance(content, dict) else content))
    return content is None or (isinstance(content, int | float) and math.isfinite(content))

"""The state of an FMU instance as one immutable value, and as bytes."""

from collections.abc import Callable
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fivtui.model.errors import InputError

from .experiment import Experiment

# Name of the top package. Within an FMU it contains a hash of the FMU's sources, and so identifies
# them.
_BUILD: Final = __name__.partition(".")[0]
# Length of the CRC-32 before the JSON text, in hexadecimal digits.
_CHECKSUM_SIZE: Final = 8
_DAMAGED: Final = "the serialised FMU state is damaged"


class Phase(StrEnum):
    """Phase of an instance in the calling sequence of FMI 2.0, as a phrase for messages."""

    INSTANTIATED = "before initialization"
    INITIALIZATION = "in initialization mode"
    STEPPING = "while stepping"
    TERMINATED = "after termination"

    def advice(self, allowed: "Phase") -> str:
        """What the host must do before a call that only the phase `allowed` permits."""
        phases = list(Phase)
        if phases.index(self) > phases.index(allowed):
            return "reset the instance first"
        if allowed is Phase.INITIALIZATION:
            return "call enter_initialization_mode first"
        return "complete the initialization first"


class InstanceState(NamedTuple):
    """The complete state of an FMU instance: phase, experiment, values of all variables, motion.

    `experiment` is None before it is set up, `motion_state` before the motion begins.
    """

    phase: Phase
    experiment: Experiment | None
    values: tuple[float | bool, ...]
    motion_state: Any


def to_bytes(state: InstanceState, to_json: Callable[[Any], Any]) -> bytes:
    """Serialise a state: eight hexadecimal digits of a checksum, then JSON with exact floats."""
    # Imported late: few hosts need it, and a host's search path may hide it.
    import json
    import zlib

    motion_state = None if state.motion_state is None else to_json(state.motion_state)
    text = json.dumps({"build": _BUILD, **state._asdict(), "motion_state": motion_state}).encode()
    return b"%08x" % zlib.crc32(text) + text


def from_bytes(data: bytes, from_json: Callable[[Any], Any]) -> InstanceState:
    """Read a state of an instance written by `to_bytes`.

    Raises `InputError` if the bytes are damaged or come from another build of the FMU.
    """
    import json
    import zlib

    checksum, text = data[:_CHECKSUM_SIZE], data[_CHECKSUM_SIZE:]
    if checksum != b"%08x" % zlib.crc32(text):
        raise InputError(_DAMAGED)
    try:
        content = json.loads(text)
    except ValueError as error:
        raise InputError(_DAMAGED) from error
    if content.pop("build") != _BUILD:
        raise InputError("the serialised FMU state comes from another build of this FMU")
    experiment, motion_state = content["experiment"], content["motion_state"]
    return InstanceState(
        Phase(content["phase"]),
        None if experiment is None else Experiment(*experiment),
        tuple(content["values"]),
        None if motion_state is None else from_json(motion_state),
    )

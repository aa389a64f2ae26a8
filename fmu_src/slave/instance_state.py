"""The state of an FMU instance as one immutable value, and as bytes."""

import json
import zlib
from collections.abc import Callable
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fivtui.model.errors import InputError

from .experiment import Experiment

# A state belongs to one build of the FMU: the package it is bundled in is named by its content.
_BUILD: Final = __name__.partition(".")[0]


class Phase(StrEnum):
    """State of an instance in the calling sequence of FMI 2.0, as words for messages."""

    INSTANTIATED = "before initialization"
    INITIALIZATION = "in initialization mode"
    STEPPING = "while stepping"
    TERMINATED = "after termination"


class InstanceState(NamedTuple):
    """All that an FMU instance remembers.

    Attributes
    ----------
    phase : Phase
        Where it is in the calling sequence.
    experiment : Experiment or None
        Times and tolerance; None before they are set up.
    values : tuple of float or bool
        Values of all variables in the order of their value references.
    motion_state : named tuple or None
        Where the motion is, with its time as `t`; None before it begins.
    """

    phase: Phase
    experiment: Experiment | None
    values: tuple[float | bool, ...]
    motion_state: Any


def to_bytes(state: InstanceState, to_json: Callable[[Any], Any]) -> bytes:
    """Serialise a state, exactly.

    Parameters
    ----------
    state : InstanceState
        The state.
    to_json : callable
        From a motion_state to what JSON can hold.

    Returns
    -------
    bytes
        A checksum and JSON; floats are written so that they read back bit for bit.
    """
    motion_state = None if state.motion_state is None else to_json(state.motion_state)
    text = json.dumps({"build": _BUILD, **state._asdict(), "motion_state": motion_state}).encode()
    return b"%08x" % zlib.crc32(text) + text


def from_bytes(data: bytes, from_json: Callable[[Any], Any]) -> InstanceState:
    """Read a state back.

    Parameters
    ----------
    data : bytes
        What `to_bytes` returned.
    from_json : callable
        From what JSON holds to a motion_state.

    Returns
    -------
    InstanceState
        The state.

    Raises
    ------
    InputError
        If the bytes are damaged or come from another build of the FMU.
    """
    checksum, text = data[:8], data[8:]
    if checksum != b"%08x" % zlib.crc32(text):
        raise InputError("the serialised FMU state is damaged")
    content = json.loads(text)
    if content.pop("build") != _BUILD:
        raise InputError("the serialised FMU state comes from another build of this FMU")
    motion_state, experiment = content["motion_state"], content["experiment"]
    return InstanceState(
        Phase(content["phase"]),
        None if experiment is None else Experiment(*experiment),
        tuple(content["values"]),
        None if motion_state is None else from_json(motion_state),
    )

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


class Memory(NamedTuple):
    """All that an FMU instance remembers.

    Attributes
    ----------
    phase : Phase
        Where it is in the calling sequence.
    experiment : Experiment or None
        Times and tolerance; None before they are set up.
    values : tuple of float or bool
        Values of all variables in the order of their value references.
    moment : named tuple or None
        Where the motion is, with its time as `t`; None before it begins.
    """

    phase: Phase
    experiment: Experiment | None
    values: tuple[float | bool, ...]
    moment: Any


def to_bytes(memory: Memory, encoded: Callable[[Any], Any]) -> bytes:
    """Serialise a state, exactly.

    Parameters
    ----------
    memory : Memory
        The state.
    encoded : callable
        From a moment to what JSON can hold.

    Returns
    -------
    bytes
        A checksum and JSON; floats are written so that they read back bit for bit.
    """
    moment = None if memory.moment is None else encoded(memory.moment)
    text = json.dumps({"build": _BUILD, **memory._asdict(), "moment": moment}).encode()
    return b"%08x" % zlib.crc32(text) + text


def from_bytes(data: bytes, decoded: Callable[[Any], Any]) -> Memory:
    """Read a state back.

    Parameters
    ----------
    data : bytes
        What `to_bytes` returned.
    decoded : callable
        From what JSON holds to a moment.

    Returns
    -------
    Memory
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
    moment, experiment = content["moment"], content["experiment"]
    return Memory(
        Phase(content["phase"]),
        None if experiment is None else Experiment(*experiment),
        tuple(content["values"]),
        None if moment is None else decoded(moment),
    )

"""The state of an FMU instance as one immutable value, and as bytes."""

import json
import zlib
from dataclasses import astuple
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fivtui.core.errors import InputError
from fivtui.core.model import Mode
from fivtui.core.segment import Segment
from fivtui.core.taylor import Instant

from .experiment import Experiment
from .motion import Moment

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
    moment : Moment or None
        Where the motion is; None before it begins.
    """

    phase: Phase
    experiment: Experiment | None
    values: tuple[float | bool, ...]
    moment: Moment | None


def to_bytes(memory: Memory) -> bytes:
    """Serialise a state, exactly.

    Parameters
    ----------
    memory : Memory
        The state.

    Returns
    -------
    bytes
        A checksum and JSON; floats are written so that they read back bit for bit.
    """
    content: dict[str, Any] = {"build": _BUILD, **memory._asdict(), "moment": None}
    if memory.moment is not None:
        segment = memory.moment.segment
        content["moment"] = {
            **memory.moment._asdict(),
            "segment": None if segment is None else astuple(segment),
        }
    text = json.dumps(content).encode()
    return b"%08x" % zlib.crc32(text) + text


def from_bytes(data: bytes) -> Memory:
    """Read a state back.

    Parameters
    ----------
    data : bytes
        What `to_bytes` returned.

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
    moment, experiment = content.pop("moment"), content["experiment"]
    return Memory(
        **{
            **content,
            "phase": Phase(content["phase"]),
            "experiment": None if experiment is None else Experiment(*experiment),
            "values": tuple(content["values"]),
            "moment": None if moment is None else _moment(moment),
        }
    )


def _moment(content: dict[str, Any]) -> Moment:
    t, remainder, state, mode, stalled = content["instant"]
    segment = content["segment"]
    return Moment(
        **{
            **content,
            "state": tuple(content["state"]),
            "mode": Mode(content["mode"]),
            "instant": Instant(t, remainder, tuple(state), Mode(mode), stalled),
            "segment": None if segment is None else _segment(segment),
        }
    )


def _segment(content: list[Any]) -> Segment:
    mode, start, remainder, duration, end, x, y, final, switches = content
    return Segment(
        Mode(mode), start, remainder, duration, end, tuple(x), tuple(y), tuple(final), switches
    )

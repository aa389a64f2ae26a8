"""Exact storage of transients in session files. Imports no Textual."""

import json
import zipfile
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from fivtui.io import write_atomically
from fivtui.model import COLUMNS, InputError, Mode, Parameters
from fivtui.transient import (
    ContactForce,
    Events,
    FinalState,
    Peak,
    Stats,
    Steady,
    Trajectory,
    Transient,
    trajectory_of,
    transient_to_dict,
)

_SAID: Final = "transient"
_SWITCHES: Final = "switch_times"
_FIRST_MODE: Final = "first_mode"


def save_kept_run(result: Transient, path: Path) -> None:
    """Write a transient with its trajectory to a ``.npz`` file."""
    said = {**transient_to_dict(result), _FIRST_MODE: int(result.first_mode)}
    motion = trajectory_of(result)
    arrays: dict[str, Any] = {column.name: getattr(motion, column.name) for column in COLUMNS}
    arrays |= {_SAID: np.array(json.dumps(said)), _SWITCHES: result.switch_times}

    def write(file: BinaryIO) -> None:
        np.savez(file, **arrays)

    write_atomically(path, write, force=True)


def load_kept_run(path: Path) -> Transient:
    """Read a transient exactly as stored; raises `InputError` if the file is damaged."""
    try:
        with path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            arrays = {name: archive[name] for name in archive.files}
        return _transient(json.loads(str(arrays[_SAID])), arrays)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        raise InputError(f"{path}: damaged") from None


def _transient(said: dict[str, Any], arrays: dict[str, Any]) -> Transient:
    start = tuple(float(value) for value in said["start"])
    return Transient(
        parameters=Parameters(**said["parameters"]),
        separation=bool(said["separation"]),
        start=(start[0], start[1], start[2], start[3]),
        t_end=float(said["t_end"]),
        method=str(said["method"]),
        tol=float(said["tol"]),
        step=said["step"],
        final=FinalState(**said["final"]),
        peak=Peak(**said["peak"]),
        steady=Steady(**said["steady"]),
        contact_force=ContactForce(**said["contact_force"]),
        events=Events(**said["events"]),
        stats=Stats(**said["stats"]),
        switch_times=arrays[_SWITCHES],
        first_mode=Mode(said[_FIRST_MODE]),
        trajectory=Trajectory(*(arrays[column.name] for column in COLUMNS)),
    )

"""Transients as plain data and in files, with units, provenance and full precision.

A trajectory file (CSV, NPZ or Parquet) has samples and the settings of the run, from which
`load_transient` estimates the results. `store_transient` writes all results exactly: they are
restored when the laboratory (the terminal program) starts again.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import (
    Columns,
    npz_arrays,
    open_regular,
    output_path,
    read_columns,
    read_header,
    write_atomically,
    write_table,
)
from fivtui.model import InputError, Mode, Parameters, State, System, time_tables
from fivtui.results import check_finite, not_finite_error
from fivtui.taylor import Extremes

from .derivatives.digits import final_digits
from .derivatives.sensitivity import Sensitivities
from .methods import FMU_FLAVOURS, uses_step
from .request import Request
from .result import (
    NO_CHANGES,
    ContactForce,
    Events,
    FinalState,
    Peak,
    Stats,
    Steady,
    Transient,
    build_transient,
)
from .trajectory import COLUMNS, Trajectory, is_in_contact

# Kind of data in the header of trajectory files.
_TRAJECTORY: Final = "trajectory"
# Names of arrays in stored files; "transient" has the data as JSON.
_DATA: Final = "transient"
_SWITCHES: Final = "switch_times"
_CHANGES: Final = "changes"
# Keys of the data of a transient.
_FIRST_MODE: Final = "first_mode"
_DIGITS: Final = "final_digits"
_SENSITIVITIES: Final = "sensitivities"
_OVER_TIME: Final = "over_time"
# Advice for results with infinite or undefined numbers.
_NOT_FINITE_ADVICE: Final = "use a shorter horizon or parameters of less extreme size"
# Types of the nested records in the data of a transient, by key.
_RECORDS: Final = {
    "final": FinalState,
    "peak": Peak,
    "steady": Steady,
    "contact_force": ContactForce,
    "events": Events,
    "stats": Stats,
}


def transient_to_dict(transient: Transient) -> dict[str, Any]:
    """A transient without its trajectory, as data for JSON, in SI units.

    Raises `ComputationError` if a number is not finite.
    """
    data = {
        **_request_data(transient),
        **{name: getattr(transient, name)._asdict() for name in _RECORDS if name != "stats"},
        "stats": asdict(transient.stats),
    }
    # JSON needs a dictionary in place of the mapping.
    data["events"]["transitions"] = dict(transient.events.transitions)
    # Squeal, groan and final stick, only if a table changes the belt speed over time.
    if transient.stop is not None:
        data["stop"] = transient.stop._asdict()
    if transient.sensitivities is not None:
        data[_SENSITIVITIES] = transient.sensitivities.to_dict()
    check_finite(data, "", _NOT_FINITE_ADVICE)
    # Numbers of reliable digits of the final state.
    digits = final_digits(transient)
    data[_DIGITS] = None if digits is None else digits._asdict()
    return data


def _request_data(transient: Transient) -> dict[str, Any]:
    # The settings of a run, as `_read_request` reads them.
    rows = {name: table.rows() for name, table in transient.over_time.items()}
    return {
        "parameters": transient.parameters.as_dict(),
        "separation": transient.separation,
        "start": list(transient.start),
        "t_end": transient.t_end,
        "method": transient.method,
        "tol": transient.tol,
        "step": transient.step,
        **({_OVER_TIME: rows} if rows else {}),
    }


def finite_trajectory(transient: Transient) -> Trajectory:
    """The trajectory of a transient, whose samples must be finite.

    Raises `InputError` if the transient was computed without sample times, and `ComputationError`
    if a sample is not finite.
    """
    trajectory = transient.trajectory
    if trajectory is None:
        raise InputError("samples: the transient has no trajectory; compute it with sample times")
    for column in COLUMNS:
        if not np.all(np.isfinite(getattr(trajectory, column.name))):
            raise not_finite_error(f"trajectory.{column.name}", _NOT_FINITE_ADVICE)
    return trajectory


def save_trajectory(transient: Transient, path: Path) -> None:
    """Write a trajectory with units and provenance.

    The same transient always gives the same bytes. Units and provenance are comment lines
    (``# key: JSON``) before the header in CSV, additional arrays in NPZ, and metadata of schema and
    fields in Parquet.
    """
    trajectory = finite_trajectory(transient)
    request = {key: value for key, value in _request_data(transient).items() if value is not None}
    values = {column.name: getattr(trajectory, column.name) for column in COLUMNS}
    write_table(path, _TRAJECTORY, COLUMNS, values, request)


def load_trajectory(path: Path) -> Trajectory:
    """Read a trajectory from a file; raises `InputError` if it has none."""
    columns = read_columns(path, _TRAJECTORY, [column.name for column in COLUMNS])
    try:
        return _trajectory_from_columns(columns)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _trajectory_from_columns(columns: Columns) -> Trajectory:
    missing = [column.name for column in COLUMNS if column.name not in columns]
    if missing:
        raise InputError(f"not a trajectory: no column {', '.join(missing)}")
    size = columns["t"].size
    for name, values in columns.items():
        if values.dtype.kind not in "fiu" or values.shape != (size,) or size == 0:
            raise InputError(f"{name}: must have one number for each time, and at least one")
        if not np.all(np.isfinite(values)):
            raise InputError(f"{name}: must be finite numbers")
    if np.any(np.diff(columns["t"]) < 0.0):
        raise InputError("t: must be ascending times")
    if not np.all(np.isin(columns["mode"], list(Mode))):
        numbers = ", ".join(f"{mode:d} ({mode.name.lower()})" for mode in Mode)
        raise InputError(f"mode: must be one of {numbers}")
    arrays: dict[str, Any] = {
        name: values.astype(np.int8 if name == "mode" else np.float64)
        for name, values in columns.items()
    }
    return Trajectory(**arrays)


def load_transient(path: Path) -> Transient:
    """Read a transient from a trajectory file that fivtui wrote."""
    motion, header = load_trajectory(path), read_header(path, _TRAJECTORY)
    try:
        return _assemble_from_samples(header, motion)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (KeyError, ValueError, TypeError, AttributeError):
        raise InputError(f"{path}: has no settings of a run; fivtui did not write it") from None


def _assemble_from_samples(header: Mapping[str, Any], motion: Trajectory) -> Transient:
    # The results of a run as estimated from its samples.
    method = str(header["method"])
    has_step = method in FMU_FLAVOURS or uses_step(method)
    request = _read_request(header, header.get("step") if has_step else None)
    separated = ~is_in_contact(motion.mode)
    # Samples before a separation or reattachment.
    indices = np.flatnonzero(separated[1:] != separated[:-1])
    switches = _crossing_times(motion, indices)
    changes = _mode_changes(motion, switches)
    # Intervals of contact and of separation alternate.
    durations = np.diff(np.concatenate(([motion.t[0]], switches, [motion.t[-1]])))
    first_separated = 0 if separated[0] else 1
    separated_durations = durations[first_separated::2]
    is_separation = separated[indices + 1]
    run = build_transient(
        request,
        final=_final_state(motion),
        extremes=_extremes(motion, 0.0),
        second_half=_extremes(motion, 0.5),
        switches=switches,
        separations=int(np.count_nonzero(is_separation)),
        separated_time=float(separated_durations.sum()),
        stats=Stats(steps=motion.t.size - 1),
        first_mode=Mode(int(motion.mode[0])),
        trajectory=motion,
        solution=None,
        changes=changes if request.parameters.v_belt is not None else NO_CHANGES,
    )
    # The final state is that of the last sample, which may be before the horizon.
    return replace(
        run,
        final=run.final._replace(t=float(motion.t[-1])),
        contact_force=ContactForce(float(motion.P.min()), float(motion.P.max())),
    )


def _final_state(motion: Trajectory) -> State:
    x, vx, y, vy = (float(values[-1]) for values in (motion.x, motion.vx, motion.y, motion.vy))
    return (x, vx, y, vy)


def _extremes(motion: Trajectory, start_fraction: float) -> Extremes:
    # Extremes of the samples after a fraction of the run.
    selected = motion.t >= start_fraction * motion.t[-1]
    x, y = motion.x[selected], motion.y[selected]
    limits = (x.min(), y.min(), x.max(), y.max(), motion.vx[selected].max())
    return Extremes(*map(float, limits))


def _mode_changes(motion: Trajectory, switches: NDArray[np.float64]) -> NDArray[np.float64]:
    # Changes of the mode between samples: separations and reattachments at the times `switches`,
    # all other changes midway between two samples.
    indices = np.flatnonzero(np.diff(motion.mode))
    before, after = motion.mode[indices], motion.mode[indices + 1]
    times = 0.5 * (motion.t[indices] + motion.t[indices + 1])
    # Each change of contact has one of the ascending times `switches`.
    is_contact_change = is_in_contact(before) != is_in_contact(after)
    times[is_contact_change] = switches
    return np.stack((times, before, after), axis=1)


def _crossing_times(motion: Trajectory, indices: NDArray[np.intp]) -> NDArray[np.float64]:
    # Times at which y crosses zero after the samples of these indices, by linear interpolation.
    y_before, y_after = motion.y[indices], motion.y[indices + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        fractions = np.where(y_before == y_after, 0.5, y_before / (y_before - y_after))
    steps = motion.t[indices + 1] - motion.t[indices]
    times: NDArray[np.float64] = motion.t[indices] + np.clip(fractions, 0.0, 1.0) * steps
    return times


def store_transient(transient: Transient, path: Path) -> None:
    """Write a transient without its dense solution, exactly, to an ``.npz`` file.

    An existing file is replaced.
    """
    data = {**transient_to_dict(transient), _FIRST_MODE: int(transient.first_mode)}
    arrays: dict[str, Any] = finite_trajectory(transient).to_columns()
    arrays |= {_DATA: np.array(json.dumps(data)), _SWITCHES: transient.switch_times}
    if transient.changes.size:
        arrays[_CHANGES] = transient.changes

    def write(file: BinaryIO) -> None:
        np.savez(file, **arrays)

    write_atomically(output_path(path, force=True), write)


def restore_transient(path: Path) -> Transient:
    """Read a file of `store_transient`; raises `InputError` if it is damaged."""
    try:
        with open_regular(path) as file, npz_arrays(file) as archive:
            arrays = {name: archive[name] for name in archive.files}
        data = json.loads(str(arrays[_DATA]))
        request, sensitivities = _read_request(data, data["step"]), data.get(_SENSITIVITIES)
        return Transient(
            request.system,
            request.initial,
            **{name: getattr(request, name) for name in ("t_end", "method", "tol", "step")},
            **{name: record(**data[name]) for name, record in _RECORDS.items()},
            switch_times=arrays[_SWITCHES],
            first_mode=Mode(data[_FIRST_MODE]),
            trajectory=Trajectory(*(arrays[column.name] for column in COLUMNS)),
            sensitivities=None if sensitivities is None else Sensitivities.from_dict(sensitivities),
            changes=arrays.get(_CHANGES, NO_CHANGES),
        )
    except (InputError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: damaged") from None


def _read_request(data: Mapping[str, Any], step: float | None) -> Request:
    p = Parameters().with_values(data["parameters"])
    return Request(
        System(p, bool(data["separation"]), time_tables(data.get(_OVER_TIME, {}))),
        t_end=float(data["t_end"]),
        tol=float(data["tol"]),
        start=[float(value) for value in data["start"]],
        method=str(data["method"]),
        step=step,
    )

"""Results in files and as plain data, with units and provenance and without loss of precision."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.io import Columns, check_finite, not_finite_error, read_columns, write_table
from fivtui.model import InputError, Mode

from .result import Transient
from .trajectory import COLUMNS, Trajectory

_KIND: Final = "trajectory"


def transient_to_dict(transient: Transient) -> dict[str, Any]:
    """A transient without its trajectory, as data that JSON can hold.

    Parameters
    ----------
    transient : Transient
        The result.

    Returns
    -------
    dict
        What was computed (``parameters``, ``separation``, ``start``, ``t_end``, ``method``,
        ``tol``, ``step``) and
        what came out (``final``, ``peak``, ``steady``, ``contact_force``, ``events``, ``stats``),
        in SI units.

    Raises
    ------
    ComputationError
        If a number is not finite.
    """
    outcome = ("final", "peak", "steady", "contact_force", "events")
    data = {
        **_request(transient),
        **{name: getattr(transient, name)._asdict() for name in outcome},
        "stats": asdict(transient.stats),
    }
    check_finite(data, "")
    return data


def _request(transient: Transient) -> dict[str, Any]:
    return {
        "parameters": transient.parameters.as_dict(),
        "separation": transient.separation,
        "start": list(transient.start),
        "t_end": transient.t_end,
        "method": transient.method,
        "tol": transient.tol,
        "step": transient.step,
    }


def trajectory_of(transient: Transient) -> Trajectory:
    """The trajectory of a transient, checked.

    Parameters
    ----------
    transient : Transient
        A result computed with sample times.

    Returns
    -------
    Trajectory
        Its trajectory.

    Raises
    ------
    InputError
        If the transient was computed without sample times.
    ComputationError
        If a sample is not finite.
    """
    trajectory = transient.trajectory
    if trajectory is None:
        raise InputError("samples: the transient has no trajectory; compute it with sample times")
    for column in COLUMNS:
        if not np.all(np.isfinite(getattr(trajectory, column.name))):
            raise not_finite_error(f"trajectory.{column.name}")
    return trajectory


def save_trajectory(transient: Transient, path: Path, *, force: bool = False) -> None:
    """Write a trajectory with units and provenance.

    The same transient always gives the same bytes. CSV has them in comment lines (``# key: JSON``)
    before the names of the columns, NPZ in arrays beside the columns, Parquet in the metadata of
    the schema and its fields.

    Parameters
    ----------
    transient : Transient
        A result computed with sample times.
    path : Path
        The file; its suffix ``.csv``, ``.npz`` or ``.parquet`` says the format.
    force : bool
        Whether a file that exists may be replaced.

    Raises
    ------
    InputError
        If there is no trajectory, the format is unknown or needs a package that is not installed,
        or the file cannot be written.
    ComputationError
        If a sample is not finite.
    """
    trajectory = trajectory_of(transient)
    request = {key: value for key, value in _request(transient).items() if value is not None}
    values = {column.name: getattr(trajectory, column.name) for column in COLUMNS}
    write_table(path, _KIND, COLUMNS, values, request, force=force)


def load_trajectory(path: Path) -> Trajectory:
    """Read a trajectory from a file.

    Parameters
    ----------
    path : Path
        A file that has the columns of `COLUMNS`, in any order; others are not read.

    Returns
    -------
    Trajectory
        Its trajectory, in SI units.

    Raises
    ------
    InputError
        If the file cannot be read, or is not a trajectory: a column is missing, a value is not a
        finite number, times do not ascend, or a mode is neither 0 nor 1.
    """
    columns = read_columns(path, _KIND, [column.name for column in COLUMNS])
    try:
        return _trajectory(columns)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _trajectory(columns: Columns) -> Trajectory:
    missing = [column.name for column in COLUMNS if column.name not in columns]
    if missing:
        raise InputError(f"not a trajectory: no column {', '.join(missing)}")
    size = columns["t"].size
    for name, values in columns.items():
        if values.dtype.kind not in "fiu" or values.shape != (size,) or size == 0:
            raise InputError(f"{name}: must be as many numbers as there are times, at least one")
        if not np.all(np.isfinite(values)):
            raise InputError(f"{name}: must be finite numbers")
    if np.any(np.diff(columns["t"]) < 0.0):
        raise InputError("t: must be ascending times")
    if not np.all(np.isin(columns["mode"], list(Mode))):
        raise InputError("mode: must be 1 (in contact) or 0 (separated)")
    arrays: dict[str, Any] = {
        name: values.astype(np.int8 if name == "mode" else np.float64)
        for name, values in columns.items()
    }
    return Trajectory(**arrays)

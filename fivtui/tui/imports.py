"""Transients read from the files that the program writes. Imports no Textual."""

import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from fivtui.core.errors import InputError
from fivtui.core.methods import takes_step
from fivtui.core.model import Mode
from fivtui.core.outcome import (
    ContactForce,
    Events,
    FinalState,
    Peak,
    Stats,
    Steady,
    Transient,
)
from fivtui.core.parameters import Parameters
from fivtui.core.trajectory import Trajectory
from fivtui.results import load_trajectory
from fivtui.scene import Scene

_KEYS: Final = ("parameters", "separation", "start", "t_end", "method", "tol", "step")


def load_run(path: Path) -> tuple[Scene, Transient]:
    """Read a transient from a trajectory file.

    Parameters
    ----------
    path : Path
        A CSV, NPZ or Parquet file that fivtui wrote: it says what was computed.

    Returns
    -------
    scene : Scene
        What was computed, named after the file.
    transient : Transient
        The motion. Extremes are those of the samples, switches are interpolated between them.

    Raises
    ------
    InputError
        If the file is not a trajectory, or does not say what was computed.
    """
    motion = load_trajectory(path)
    try:
        with path.open("rb") as file:
            known = _READERS[path.suffix.lower()](file)
        scene = _scene(path.stem, known)
        start = tuple(float(value) for value in known["start"])
    except (KeyError, ValueError, TypeError, AttributeError, OSError):
        raise InputError(
            f"{path}: does not say what was computed; fivtui did not write it"
        ) from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return scene, _transient(scene, start, motion)


def _from_csv(file: BinaryIO) -> dict[str, Any]:
    known = {}
    with io.TextIOWrapper(file, encoding="utf-8-sig") as lines:
        for line in lines:
            if not line.startswith("#"):
                break
            key, _, text = line.removeprefix("#").partition(":")
            if key.strip() in _KEYS:
                known[key.strip()] = json.loads(text)
    return known


def _from_npz(file: BinaryIO) -> dict[str, Any]:
    with np.load(file, allow_pickle=False) as archive:
        known = {key: archive[key] for key in _KEYS if key in archive}
    names = known["parameters"].dtype.names or ()
    parameters = {name: float(known["parameters"][name]) for name in names}
    return {**{key: value.tolist() for key, value in known.items()}, "parameters": parameters}


def _from_parquet(file: BinaryIO) -> dict[str, Any]:
    import pyarrow.parquet as pq

    metadata = pq.read_schema(file).metadata or {}
    return {key: json.loads(metadata[key.encode()]) for key in _KEYS if key.encode() in metadata}


_READERS: Final[Mapping[str, Callable[[BinaryIO], dict[str, Any]]]] = {
    ".csv": _from_csv,
    ".npz": _from_npz,
    ".parquet": _from_parquet,
}


def _scene(name: str, known: Mapping[str, Any]) -> Scene:
    method, step = str(known["method"]), known.get("step")
    if method != "fmu" and not takes_step(method):
        step = None
    return Scene(
        name=name,
        description="",
        parameters=Parameters().with_values(known["parameters"]),
        separation=bool(known["separation"]),
        start=[float(value) for value in known["start"]],
        t_end=float(known["t_end"]),
        tol=float(known["tol"]),
        method=method,
        step=step,
    )


def _transient(scene: Scene, start: tuple[float, ...], motion: Trajectory) -> Transient:
    off = motion.mode == Mode.SEPARATED
    edges = np.flatnonzero(off[1:] != off[:-1])
    switches = _crossings(motion, edges)
    separations = int(np.count_nonzero(off[1:][edges]))
    late = motion.y[motion.t >= 0.5 * motion.t[-1]]
    y_max, y_min = float(motion.y.max()), float(motion.y.min())
    first, last = (float(switches[0]), float(switches[-1])) if switches.size else (None, None)
    bounds = np.concatenate(([motion.t[0]], switches, [motion.t[-1]]))
    separated = np.diff(bounds)[0 if off[0] else 1 :: 2]
    return Transient(
        parameters=scene.parameters,
        separation=scene.separation,
        start=(start[0], start[1], start[2], start[3]),
        t_end=float(motion.t[-1]),
        method=scene.method,
        tol=scene.tol,
        step=scene.step,
        final=FinalState(
            *(float(values[-1]) for values in (motion.t, motion.x, motion.vx, motion.y, motion.vy))
        ),
        peak=Peak(
            y_abs=max(y_max, -y_min),
            y_max=y_max,
            y_min=y_min,
            x_abs=float(np.abs(motion.x).max()),
            vx_max=float(motion.vx.max()),
        ),
        steady=Steady(y_half_range=0.5 * float(late.max() - late.min())),
        contact_force=ContactForce(min=float(motion.P.min()), max=float(motion.P.max())),
        events=Events(
            separations=separations,
            reattachments=switches.size - separations,
            separated_time=float(separated.sum()),
            first=first,
            last=last,
        ),
        stats=Stats(steps=motion.t.size - 1),
        switch_times=switches,
        first_mode=Mode.SEPARATED if off[0] else Mode.CONTACT,
        trajectory=motion,
    )


def _crossings(
    motion: Trajectory, edges: np.ndarray[Any, np.dtype[np.intp]]
) -> np.ndarray[Any, np.dtype[np.float64]]:
    # Where y passes zero between two samples of different mode, on the straight line between them.
    before, after = motion.y[edges], motion.y[edges + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(before == after, 0.5, before / (before - after))
    times = motion.t[edges] + np.clip(share, 0.0, 1.0) * (motion.t[edges + 1] - motion.t[edges])
    crossings: np.ndarray[Any, np.dtype[np.float64]] = times
    return crossings

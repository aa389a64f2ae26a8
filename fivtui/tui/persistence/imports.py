"""Reads result files written by fivtui. Imports no Textual."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.io import FORMATS, check_regular, is_folder, read_bytes, read_header
from fivtui.model import InputError, Mode, Parameters
from fivtui.scene import Scene
from fivtui.transient import (
    ContactForce,
    Events,
    FinalState,
    Peak,
    Stats,
    Steady,
    Trajectory,
    Transient,
    load_trajectory,
    takes_step,
)

RUN: Final = "run"
SWEEP: Final = "sweep"
MAP: Final = "map"
TRADEOFF: Final = "trade-off"
SUFFIXES: Final = (*FORMATS, ".json", ".parts")
# Keys of a file's provenance and its kind; the first match counts.
_BY_PROVENANCE: Final = (
    (("sweep",), SWEEP),
    (("floor",), TRADEOFF),
    (("method", "t_end"), RUN),
)
# Keys of the command line's JSON output, and its kind.
_BY_KEYS: Final = ((("floor", "rows"), TRADEOFF), (("over", "values"), MAP))
# JSON output that cannot be read, and what to read instead.
_OTHER_JSON: Final = (
    (("columns", "rows"), "does not say which sweep it is from; read the file of sweep --out"),
    (("final", "peak"), "has no motion over time; read the file of simulate --out"),
)
_MAP_COLUMNS: Final = {"parameters", "separation", "fivtui"}


def check_readable(path: Path) -> None:
    """Raise `InputError` unless a path can be a result file or an unfinished sweep's folder."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: a result has one of the suffixes {', '.join(SUFFIXES)}")
    if not is_folder(path):
        check_regular(path)


def kind_of(path: Path) -> str:
    """The kind of result in a file: `RUN`, `SWEEP`, `MAP` or `TRADEOFF`.

    Raises `InputError` if it is none of these.
    """
    check_readable(path)
    if is_folder(path):
        return SWEEP
    if path.suffix.lower() == ".json":
        return _kind_of_json(path)
    said = read_header(path, "result")
    for keys, kind in _BY_PROVENANCE:
        if all(key in said for key in keys):
            return kind
    if set(said) == _MAP_COLUMNS:
        return MAP
    # `load_run` raises the error for a file without provenance.
    if not said:
        return RUN
    raise InputError(f"{path}: not a run, sweep, map or trade-off")


def _kind_of_json(path: Path) -> str:
    content = read_bytes(path)
    try:
        data = json.loads(content)
    except (ValueError, RecursionError):
        raise InputError(f"{path}: not JSON, or damaged") from None
    known = set(data) if isinstance(data, dict) else set()
    for keys, kind in _BY_KEYS:
        if known.issuperset(keys):
            return kind
    for keys, words in _OTHER_JSON:
        if known.issuperset(keys):
            raise InputError(f"{path}: {words}")
    raise InputError(f"{path}: not a sweep, map or trade-off")


def load_study(kind: str, path: Path) -> Any:
    """Read a sweep, map or trade-off; raises `InputError` if it cannot be read or displayed."""
    return _STUDY_READERS[kind](path)


def _read_sweep(path: Path) -> Any:
    from fivtui.sweeps import read_sweep
    from fivtui.tui.session import check_drawable

    result = read_sweep(path)
    try:
        check_drawable(result.study)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return result


def _read_map(path: Path) -> Any:
    from fivtui.equilibrium import load_map

    return load_map(path)


def _read_tradeoff(path: Path) -> Any:
    from fivtui.tradeoffs import load_tradeoff

    return load_tradeoff(path)


_STUDY_READERS: Final[Mapping[str, Callable[[Path], Any]]] = {
    SWEEP: _read_sweep,
    MAP: _read_map,
    TRADEOFF: _read_tradeoff,
}


def load_run(path: Path) -> tuple[Scene, Transient]:
    """Read a scene and transient from a trajectory file.

    Extrema are those of the samples; switching times are interpolated between samples. Raises
    `InputError` if the file is not a trajectory or does not say what was computed.
    """
    motion = load_trajectory(path)
    try:
        known = read_header(path, "trajectory")
        scene = _scene(path.stem, known)
        start = tuple(float(value) for value in known["start"])
    except (KeyError, ValueError, TypeError, AttributeError):
        raise InputError(
            f"{path}: does not say what was computed; fivtui did not write it"
        ) from None
    except InputError as error:
        words = str(error).removeprefix(f"{path}: ")
        raise InputError(f"{path}: {words}") from None
    return scene, _transient(scene, start, motion)


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
    # Zero crossings of y between samples of different mode, by linear interpolation.
    before, after = motion.y[edges], motion.y[edges + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(before == after, 0.5, before / (before - after))
    times = motion.t[edges] + np.clip(share, 0.0, 1.0) * (motion.t[edges + 1] - motion.t[edges])
    crossings: np.ndarray[Any, np.dtype[np.float64]] = times
    return crossings

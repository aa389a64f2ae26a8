"""The registry of studies: all kinds of results, with their files, figures, tables and commands.

A study is a computation with its own kind of result, such as a run, a sweep or a map. The
laboratory, fivtui's terminal program, stores its results between two starts: its session.
"""

import json
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, Final, cast

from fivtui.io import (
    FORMATS,
    check_output,
    check_regular,
    check_suffix,
    is_folder,
    read_bytes,
    read_header,
    save_json,
    table_format,
)
from fivtui.model import InputError
from fivtui.results import Command, StudyKind

# Module and name of the entry of every kind. Files are recognised in this order, the map last, as
# its header is the least specific.
STUDIES: Final[dict[str, str]] = {
    "run": "fivtui.transient.kinds:RUN",
    "simulation": "fivtui.scene.kinds:SIMULATION",
    "film": "fivtui.film.kinds:FILM",
    "sound": "fivtui.signals.kinds:SOUND",
    "validation": "fivtui.measured.kinds:VALIDATION",
    "identification": "fivtui.identification.kinds:IDENTIFICATION",
    "uncertainty": "fivtui.reliability.kinds:UNCERTAINTY",
    "sweep": "fivtui.sweeps.kinds:SWEEP",
    "trade-off": "fivtui.tradeoffs.kinds:TRADEOFF",
    "stability": "fivtui.equilibrium.kinds:STABILITY",
    "attractors": "fivtui.orbits.kinds:ATTRACTORS",
    "attractor": "fivtui.orbits.kinds:ATTRACTOR",
    "branches": "fivtui.orbits.kinds:BRANCHES",
    "branch": "fivtui.orbits.kinds:BRANCH",
    "boundary": "fivtui.orbits.kinds:BOUNDARY",
    "basin": "fivtui.orbits.kinds:BASIN",
    "safe-friction": "fivtui.safety.kinds:SAFE_FRICTION",
    "accuracy": "fivtui.assessment.kinds:ACCURACY",
    "extremes": "fivtui.assessment.kinds:EXTREMES",
    "figure": "fivtui.paper.kinds:FIGURE",
    "claims": "fivtui.paper.kinds:CLAIMS",
    "map": "fivtui.maps.kinds:MAP",
}
_JSON: Final = ".json"


def study(name: str) -> StudyKind:
    """The entry of a kind of study, such as ``"map"``; its functions are imported when called."""
    module, _, entry = STUDIES[name].partition(":")
    return cast("StudyKind", getattr(import_module(module), entry))


def studies() -> Iterator[tuple[str, StudyKind]]:
    """Names and entries of all kinds, in the order in which files are recognised."""
    return ((name, study(name)) for name in STUDIES)


def check_study_path(name: str, path: Path) -> None:
    """Check that a result can be written to a file, before it is computed."""
    kind = study(name)
    if path.suffix.lower() in FORMATS and path.suffix.lower() in kind.suffixes:
        # Raises `InputError` if the package of the format is missing.
        table_format(path, kind.contents_name)
    check_suffix(path, kind.contents_name, kind.suffixes)
    check_output(path)


def save_study(name: str, result: Any, path: Path) -> None:
    """Write a result to a file."""
    kind = study(name)
    if path.suffix.lower() == _JSON and _JSON not in kind.suffixes:
        save_json(kind.to_dict(result), path)
    else:
        kind.save(result, path)


def check_readable(path: Path) -> None:
    """Raise `InputError` unless a file or folder exists and its suffix is one of a result."""
    folders = (suffix for _, kind in studies() for suffix in kind.folders)
    suffixes = (*FORMATS, *folders, _JSON)
    if path.suffix.lower() not in suffixes:
        names = ", ".join(suffixes)
        raise InputError(f"{path}: a result has one of the suffixes {names}; a scene has .toml")
    if not is_folder(path):
        check_regular(path)


def kind_of(path: Path) -> str:
    """The kind of result that a file holds."""
    check_readable(path)
    suffix = path.suffix.lower()
    if is_folder(path):
        kind_name = next((name for name, kind in studies() if suffix in kind.folders), "")
    elif suffix == _JSON:
        kind_name = _kind_of_json(path)
    else:
        header = read_header(path, "result").keys()
        matching_kinds = (
            name for name, kind in studies() if kind.header_keys and header >= kind.header_keys
        )
        # A trajectory written by another program has no header.
        kind_name = next(matching_kinds, "") if header else "run"
    if not kind_name or study(kind_name).load is None:
        names = [name for name, kind in studies() if kind.load is not None]
        raise InputError(f"{path}: not a {', '.join(names[:-1])} or {names[-1]}")
    return kind_name


def _kind_of_json(path: Path) -> str:
    content = read_bytes(path)
    try:
        data = json.loads(content)
    except (ValueError, RecursionError):
        raise InputError(f"{path}: not JSON, or damaged") from None
    keys = data.keys() if isinstance(data, dict) else set()
    for name, kind in studies():
        if kind.json_keys and keys >= kind.json_keys:
            # What --json prints of some results is not enough to restore them.
            if kind.json_refusal:
                raise InputError(f"{path}: {kind.json_refusal}")
            return name
    return ""


def load_study(name: str, path: Path) -> Any:
    """Read a result of a kind (see `kind_of`) from a file; raises `InputError` if that fails."""
    load = study(name).load
    if load is None:
        raise InputError(f"{path}: {study(name).contents_name} cannot be read")
    return load(path)


def store_study(name: str, result: Any, path: Path) -> None:
    """Write all that `restore_study` needs; what `save_study` writes may be only a part of it."""
    storage = study(name).storage
    if storage is not None and storage.save is not None:
        storage.save(result, path)
    else:
        save_study(name, result, path)


def restore_study(name: str, path: Path) -> Any:
    """Read what `store_study` wrote; raises `InputError` if it cannot be read."""
    storage = study(name).storage
    if storage is None:
        raise InputError(f"{name}: such results are not stored in a session")
    return load_study(name, path) if storage.load is None else storage.load(path)


def build_command(name: str, subject: Any) -> Command:
    """The command that computes a study; `subject` is its result or its request."""
    command = study(name).command
    if command is None:
        raise InputError(f"{name}: no command computes such a study")
    return command(subject)

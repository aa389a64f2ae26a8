"""The transient among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from .result import Transient

_SAID: Final = (*PHYSICS, "start", "t_end", "method", "tol", "accuracy", "step")
_COLUMNS: Final = 7
_BYTES: Final = 8


def _show(result: "Transient") -> None:
    from .report import print_transient

    print_transient(result)


def _save(result: "Transient", path: Path, force: bool) -> None:
    from .files import save_trajectory

    save_trajectory(result, path, force=force)


def _load(path: Path) -> "Transient":
    from .files import load_transient

    return load_transient(path)


def _store(result: "Transient", path: Path) -> None:
    from .files import store_transient

    store_transient(result, path)


def _restore(path: Path) -> "Transient":
    from .files import restore_transient

    return restore_transient(path)


def _size(result: "Transient") -> int:
    return 0 if result.trajectory is None else _COLUMNS * _BYTES * int(result.trajectory.t.size)


def _command(scene: Any) -> Command:
    return Command("simulate", scene_fields(scene, _SAID), _SAID)


RUN: Final = StudyKind(
    data="trajectory",
    show=_show,
    suffixes=(".csv", ".npz", ".parquet"),
    save=_save,
    load=_load,
    load_suffixes=(".csv", ".npz", ".parquet"),
    header=frozenset({"method", "t_end"}),
    json_keys=frozenset({"final", "peak"}),
    json_refusal="has no motion over time; read the file of simulate --out",
    command=_command,
    stored=Stored(".npz", _store, _restore, _size),
)

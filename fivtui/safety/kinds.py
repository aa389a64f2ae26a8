"""Verdicts on friction and maps, those of stability included, among the studies."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.equilibrium import MAP as STABILITY_MAP
from fivtui.results import Stored, StudyKind

if TYPE_CHECKING:
    from . import files, report
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_BYTES: Final = 8
_COLUMNS: Final = 6

SAFE_FRICTION: Final = StudyKind(data="verdict", show=report.print_safe_friction)


def _is_safety(result: Any) -> bool:
    return hasattr(result, "safe_mu")


def _show(result: Any) -> None:
    show = report.print_safety_map if _is_safety(result) else STABILITY_MAP.show
    show(result)


def _save(result: Any, path: Path, *, force: bool = False) -> None:
    save = files.save_safety_map if _is_safety(result) else STABILITY_MAP.save
    save(result, path, force=force)


def _load(path: Path) -> Any:
    plain = STABILITY_MAP.load
    assert plain is not None  # noqa: S101
    return files.load_safety_map(path) if files.is_safety_map(path) else plain(path)


def _size(result: Any) -> int:
    return _COLUMNS * _BYTES * int(result.values.size)


MAP: Final = replace(
    STABILITY_MAP,
    show=_show,
    save=_save,
    load=_load,
    stored=Stored(".npz", _save, _load, _size),
)

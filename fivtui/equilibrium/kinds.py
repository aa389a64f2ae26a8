"""Stability among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import PHYSICS, Command, StudyKind, scene_fields

if TYPE_CHECKING:
    from . import files, report
    from .eigenvalues import Stability
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_FORMATS: Final = tuple(FORMATS)


def _save_modes(result: "Stability", path: Path, *, force: bool) -> None:
    files.save_modes(result, result.modes_over_mu(), path, force=force)


STABILITY: Final = StudyKind(
    data="table of modes",
    show=report.print_stability,
    suffixes=_FORMATS,
    save=_save_modes,
    as_json=True,
    stem=lambda _: "stability",
    header=frozenset({"critical_mu"}),
    json_keys=frozenset({"eigenvalues", "critical_mu"}),
    command=lambda scene: Command("stability", scene_fields(scene, PHYSICS)),
)

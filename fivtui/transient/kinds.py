"""The transient among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.lazy import later
from fivtui.results import TABLES, Stored, StudyKind, command_for

from .settings.options import SimulateOptions

if TYPE_CHECKING:
    from .result import Transient

files, report = later(__name__, "files", "report")
_COLUMNS: Final = 7
_BYTES: Final = 8


def _size(result: "Transient") -> int:
    return 0 if result.trajectory is None else _COLUMNS * _BYTES * int(result.trajectory.t.size)


RUN: Final = StudyKind(
    data="trajectory",
    show=report.print_transient,
    suffixes=TABLES,
    save=files.save_trajectory,
    load=files.load_transient,
    header=frozenset({"method", "t_end"}),
    json_keys=frozenset({"final", "peak"}),
    json_refusal="has no motion over time; read the file of simulate --out",
    command=lambda scene: command_for(
        "simulate", scene, SimulateOptions(), needed={"over_time": scene.over_time}
    ),
    stored=Stored(".npz", files.store_transient, files.restore_transient, _size),
)

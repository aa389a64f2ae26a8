"""The trade-off among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import save_json
from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from . import files, report
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_SAID: Final = (*PHYSICS, "start", "t_end")

TRADEOFF: Final = StudyKind(
    data="trade-off",
    show=report.print_tradeoff,
    suffixes=(".csv",),
    save=files.save_tradeoff,
    as_json=True,
    stem=lambda _: "tradeoff",
    load=files.load_tradeoff,
    load_suffixes=(".csv", ".json"),
    header=frozenset({"floor"}),
    json_keys=frozenset({"floor", "rows"}),
    command=lambda scene: Command("tradeoff", scene_fields(scene, _SAID), _SAID),
    stored=Stored(
        ".json",
        lambda result, path: save_json(result.to_dict(), path),
        files.load_tradeoff,
    ),
)

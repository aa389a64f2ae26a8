"""The trade-off among the studies."""

from typing import Final

from fivtui.lazy import later
from fivtui.results import PHYSICS, Command, Stored, StudyKind, scene_fields

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
    header=frozenset({"floor"}),
    json_keys=frozenset({"floor", "rows"}),
    command=lambda scene: Command("tradeoff", scene_fields(scene, _SAID), _SAID),
    stored=Stored(".json"),
)

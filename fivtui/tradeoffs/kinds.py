"""Kind of study: the trade-off."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import Storage, StudyKind, command_for

from .options import TradeoffOptions

files, report = lazy_modules(__name__, "files", "report")

TRADEOFF: Final = StudyKind(
    contents_name="trade-off",
    show=report.print_tradeoff,
    suffixes=(".csv",),
    save=files.save_tradeoff,
    as_json=True,
    stem=lambda _: "tradeoff",
    load=files.load_tradeoff,
    header_keys=frozenset({"floor"}),
    json_keys=frozenset({"floor", "rows"}),
    command=lambda scene: command_for("tradeoff", scene, TradeoffOptions()),
    stored=Storage(".json"),
)

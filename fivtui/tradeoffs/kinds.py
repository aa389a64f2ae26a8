"""Kind of study: how the command line and the laboratory treat a trade-off.

The laboratory is the terminal program. A kind has functions that print, save and read a result.
"""

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
    # The laboratory offers to save JSON, too.
    as_json=True,
    stem=lambda _: "tradeoff",
    load=files.load_tradeoff,
    # A table is recognised as a trade-off by these keys of its header, JSON by the next ones.
    header_keys=frozenset({"floor"}),
    json_keys=frozenset({"floor", "rows"}),
    # The command line that measures a scene, for display and copying.
    command=lambda scene: command_for("tradeoff", scene, TradeoffOptions()),
    storage=Storage(".json"),
)

"""Curves over two parameters among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind, save_result

if TYPE_CHECKING:
    from . import report
else:
    from fivtui.lazy import later

    (report,) = later(__name__, "report")

BOUNDARY: Final = StudyKind(
    data="boundary",
    show=report.print_boundary,
    suffixes=tuple(FORMATS),
    save=save_result,
    as_json=True,
    stem=lambda result: f"{result.kind}-{'-'.join(result.names)}",
    header=frozenset({"curve_events"}),
    json_keys=frozenset({"curve", "over", "curves"}),
)

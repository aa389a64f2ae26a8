"""Curves over two parameters among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import files, report
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

BOUNDARY: Final = StudyKind(
    data="boundary",
    show=report.print_boundary,
    warning=files.warning_on,
    suffixes=tuple(FORMATS),
    save=files.save_boundary,
    as_json=True,
    stem=lambda result: f"{result.kind}-{'-'.join(result.names)}",
    header=frozenset({"curve_events"}),
    json_keys=frozenset({"curve", "over", "curves"}),
)

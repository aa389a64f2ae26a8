"""Entry of curves over two parameters in the registry of studies."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import TABLE_SUFFIXES, StudyKind

(report,) = lazy_modules(__name__, "report")

BOUNDARY: Final = StudyKind(
    data="boundary",
    show=report.print_boundary,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"{result.kind}-{'-'.join(result.names)}",
    header=frozenset({"curve_events"}),
    json_keys=frozenset({"curve", "over", "curves"}),
)

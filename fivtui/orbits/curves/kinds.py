"""Branches of limit cycles among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import files, report
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_FORMATS: Final = tuple(FORMATS)

BRANCH: Final = StudyKind(
    data="branch",
    show=report.print_branch,
    warning=files.warning_on,
    suffixes=_FORMATS,
    save=files.save_branch,
    as_json=True,
    stem=lambda result: f"branch-{result.name}",
    header=frozenset({"event_kinds"}),
    json_keys=frozenset({"parameter", "points", "events"}),
)

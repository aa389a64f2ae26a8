"""Verdicts on friction among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import report
else:
    from fivtui.lazy import later

    (report,) = later(__name__, "report")

SAFE_FRICTION: Final = StudyKind(data="verdict", show=report.print_safe_friction)

"""The transient of a scene, verified if the scene asks for an accuracy, among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import report
else:
    from fivtui.lazy import later

    (report,) = later(__name__, "report")

SIMULATION: Final = StudyKind(data="transient", show=report.print_run)

"""The transient of a scene, verified if the scene asks for an accuracy, among the studies."""

from typing import Final

from fivtui.lazy import later
from fivtui.results import StudyKind

(report,) = later(__name__, "report")

SIMULATION: Final = StudyKind(data="transient", show=report.print_run)

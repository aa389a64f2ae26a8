"""Kind of study: the transient of a scene, verified if the scene has error targets."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import StudyKind

(report,) = lazy_modules(__name__, "report")

SIMULATION: Final = StudyKind(contents_name="transient", show=report.print_run)

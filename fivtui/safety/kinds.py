"""Kind of study: the verdict on safe friction."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import StudyKind, list_printer

(phrases,) = lazy_modules(__name__, "phrases")

SAFE_FRICTION: Final = StudyKind(
    contents_name="verdict", show=list_printer("Disturbances of any size", phrases.verdict_rows)
)

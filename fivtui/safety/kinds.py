"""Verdicts on friction among the studies."""

from typing import Final

from fivtui.lazy import later
from fivtui.results import StudyKind, listed

(words,) = later(__name__, "words")

SAFE_FRICTION: Final = StudyKind(
    data="verdict", show=listed("Disturbances of any size", words.verdict_rows)
)

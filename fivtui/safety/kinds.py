"""Verdicts on friction among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind, listed

if TYPE_CHECKING:
    from . import words
else:
    from fivtui.lazy import later

    (words,) = later(__name__, "words")

SAFE_FRICTION: Final = StudyKind(
    data="verdict", show=listed("Disturbances of any size", words.verdict_rows)
)

"""Films among the studies."""

from typing import Final

from fivtui.results import StudyKind, listed

FILM: Final = StudyKind(data="film", show=listed("Film"))

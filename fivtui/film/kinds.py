"""The kind of study of a film."""

from typing import Final

from fivtui.results import StudyKind, list_printer

FILM: Final = StudyKind(data="film", show=list_printer("Film"))

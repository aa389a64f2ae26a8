"""Entry of films in the registry of studies: how the result of ``fivtui animate`` is printed."""

from typing import Final

from fivtui.results import StudyKind, list_printer

FILM: Final = StudyKind(contents_name="film", show=list_printer("Film"))

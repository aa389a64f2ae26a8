"""Kind of study: the sound of a run."""

from typing import Final

from fivtui.results import StudyKind, list_printer

SOUND: Final = StudyKind(contents_name="sound", show=list_printer("Sound"))

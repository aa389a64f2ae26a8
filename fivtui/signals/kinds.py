"""The kind of study of a sound."""

from typing import Final

from fivtui.results import StudyKind, list_printer

SOUND: Final = StudyKind(data="sound", show=list_printer("Sound"))

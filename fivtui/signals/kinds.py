"""Sounds among the studies."""

from typing import Final

from fivtui.results import StudyKind, listed

SOUND: Final = StudyKind(data="sound", show=listed("Sound"))

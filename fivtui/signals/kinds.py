"""Sounds among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from .audio import SoundFile


def _print(result: "SoundFile") -> None:
    from fivtui.console import print_list

    print_list("Sound", result._summary())


SOUND: Final = StudyKind(data="sound", show=_print)

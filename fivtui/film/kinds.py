"""Films among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from .figure import Film


def _print(result: "Film") -> None:
    from fivtui.console import print_list

    print_list("Film", result._summary())


FILM: Final = StudyKind(data="film", show=_print)

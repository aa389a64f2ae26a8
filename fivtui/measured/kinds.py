"""Comparisons of a run with a measurement among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import comparison
    from .comparison import Validation
else:
    from fivtui.lazy import later

    (comparison,) = later(__name__, "comparison")


def _print(result: "Validation") -> None:
    from fivtui.console import print_list

    print_list("Run beside measured data", result._summary())


VALIDATION: Final = StudyKind(
    data="validation",
    show=_print,
    suffixes=tuple(FORMATS),
    save=comparison.save_validation,
    as_json=True,
    stem=lambda result: f"validation-{result.quantity}",
)

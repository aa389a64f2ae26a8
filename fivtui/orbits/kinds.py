"""Attractors, their continuations and their basins among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind, save_result

if TYPE_CHECKING:
    from . import report
else:
    from fivtui.lazy import later

    (report,) = later(__name__, "report")

_FORMATS: Final = tuple(FORMATS)

ATTRACTOR: Final = StudyKind(
    data="attractor",
    show=lambda result: report.print_attractors([result]),
)

ATTRACTORS: Final = StudyKind(
    data="attractor",
    show=report.print_coexistence,
    json_keys=frozenset({"attractors", "coexistence"}),
)

BRANCHES: Final = StudyKind(
    data="attractor",
    show=report.print_continuation,
    suffixes=_FORMATS,
    save=save_result,
    as_json=True,
    stem=lambda result: f"branches-{result.name}",
    header=frozenset({"kinds"}),
    json_keys=frozenset({"points", "coexisting"}),
)

BASIN: Final = StudyKind(
    data="attractor",
    show=report.print_basin,
    suffixes=_FORMATS,
    save=save_result,
    as_json=True,
    stem=lambda result: f"basin-{'-'.join(result.names)}",
    header=frozenset({"attractors"}),
    json_keys=frozenset({"reached", "over"}),
)

"""Attractors, their continuations and their basins among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.results import StudyKind

if TYPE_CHECKING:
    from . import files, report
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_FORMATS: Final = tuple(FORMATS)

ATTRACTOR: Final = StudyKind(
    data="attractor",
    show=lambda result: report.print_attractors([result]),
    to_dict=files.attractor_to_dict,
)

ATTRACTORS: Final = StudyKind(
    data="attractor",
    show=report.print_coexistence,
    warning=files.warning_of,
    json_keys=frozenset({"attractors", "coexistence"}),
)

BRANCHES: Final = StudyKind(
    data="attractor",
    show=report.print_continuation,
    warning=files.warning_along,
    suffixes=_FORMATS,
    save=files.save_continuation,
    as_json=True,
    stem=lambda result: f"branches-{result.name}",
    header=frozenset({"kinds"}),
    json_keys=frozenset({"points", "coexisting"}),
)

BASIN: Final = StudyKind(
    data="attractor",
    show=report.print_basin,
    warning=files.warning_in,
    suffixes=_FORMATS,
    save=files.save_basin,
    as_json=True,
    stem=lambda result: f"basin-{'-'.join(result.names)}",
    header=frozenset({"attractors"}),
    json_keys=frozenset({"reached", "over"}),
)

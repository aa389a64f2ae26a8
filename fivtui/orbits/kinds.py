"""Entries of attractors, continuations and basins in the registry of studies."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import TABLE_SUFFIXES, StudyKind

(report,) = lazy_modules(__name__, "report")

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
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"branches-{result.name}",
    header=frozenset({"kinds"}),
    json_keys=frozenset({"points", "coexisting"}),
)

BASIN: Final = StudyKind(
    data="attractor",
    show=report.print_basin,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"basin-{'-'.join(result.names)}",
    header=frozenset({"attractors"}),
    json_keys=frozenset({"reached", "over"}),
)

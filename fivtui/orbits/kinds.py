"""Attractors, their branches and their basins among the studies."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from fivtui.results import StudyKind

if TYPE_CHECKING:
    from .attractor_search import Coexistence
    from .basins import Basin
    from .branches import Continuation
    from .explorer import Attractor

_FORMATS: Final = (".csv", ".npz", ".parquet")


def _show_attractor(result: "Attractor") -> None:
    from .report import print_attractors

    print_attractors([result])


def _attractor_to_dict(result: "Attractor") -> object:
    from .files import attractor_to_dict

    return attractor_to_dict(result)


ATTRACTOR: Final = StudyKind(data="attractor", show=_show_attractor, to_dict=_attractor_to_dict)


def _show_attractors(result: "Coexistence") -> None:
    from .report import print_coexistence

    print_coexistence(result)


def _warning_of(result: "Coexistence") -> str | None:
    from .files import warning_of

    return warning_of(result)


ATTRACTORS: Final = StudyKind(
    data="attractor",
    show=_show_attractors,
    warning=_warning_of,
    json_keys=frozenset({"attractors", "coexistence"}),
)


def _show_branches(result: "Continuation") -> None:
    from .report import print_continuation

    print_continuation(result)


def _warning_along(result: "Continuation") -> str | None:
    from .files import warning_along

    return warning_along(result)


def _save_branches(result: "Continuation", path: Path, force: bool) -> None:
    from .files import save_continuation

    save_continuation(result, path, force=force)


BRANCHES: Final = StudyKind(
    data="attractor",
    show=_show_branches,
    warning=_warning_along,
    suffixes=_FORMATS,
    save=_save_branches,
    as_json=True,
    stem=lambda result: f"branches-{result.name}",
    header=frozenset({"kinds"}),
    json_keys=frozenset({"points", "coexisting"}),
)


def _show_basin(result: "Basin") -> None:
    from .report import print_basin

    print_basin(result)


def _warning_in(result: "Basin") -> str | None:
    from .files import warning_in

    return warning_in(result)


def _save_basin(result: "Basin", path: Path, force: bool) -> None:
    from .files import save_basin

    save_basin(result, path, force=force)


BASIN: Final = StudyKind(
    data="attractor",
    show=_show_basin,
    warning=_warning_in,
    suffixes=_FORMATS,
    save=_save_basin,
    as_json=True,
    stem=lambda result: f"basin-{'-'.join(result.names)}",
    header=frozenset({"attractors"}),
    json_keys=frozenset({"reached", "over"}),
)

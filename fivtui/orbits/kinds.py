"""Kinds of study: attractors, continuations, basins, branches and curves over two parameters.

A `StudyKind` tells the command line and the laboratory how to handle a result: `data` names it in
messages, `show` prints it, `header` and `json_keys` are the keys by which its files are recognised.
"""

from typing import TYPE_CHECKING, Final

from fivtui.lazy import LazyModule, lazy_modules
from fivtui.model import InputError
from fivtui.results import TABLE_SUFFIXES, Command, Storage, StudyKind, command_for

from .options import BranchOptions

if TYPE_CHECKING:
    from .curves.result import CycleBranch

# Modules that are imported when one of their functions is called.
(report,) = lazy_modules(__name__, "report")
branch_files = LazyModule("fivtui.orbits.curves.files")
hopf = LazyModule("fivtui.orbits.curves.hopf")

ATTRACTOR: Final = StudyKind(
    contents_name="attractor",
    show=lambda result: report.print_attractors([result]),
)

ATTRACTORS: Final = StudyKind(
    contents_name="attractor",
    show=report.print_coexistence,
    json_keys=frozenset({"attractors", "coexistence"}),
)

# Attractors along a parameter, which transients reach.
BRANCHES: Final = StudyKind(
    contents_name="attractor",
    show=report.print_continuation,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"branches-{result.name}",
    header_keys=frozenset({"kinds"}),
    json_keys=frozenset({"points", "coexisting"}),
)

BASIN: Final = StudyKind(
    contents_name="attractor",
    show=report.print_basin,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"basin-{'-'.join(result.names)}",
    header_keys=frozenset({"attractors"}),
    json_keys=frozenset({"reached", "over"}),
)


def _branch_command(result: "CycleBranch") -> Command:
    # The command that computes a branch again. `InputError` if no option gives its start.
    if result.origin == "file":
        raise InputError("branch: no command repeats it: no option gives the cycle it begins at")
    if result.doubled and not _is_start_known(result):
        raise InputError(
            f"branch: no command repeats it: its file lacks the scene's value of {result.name}, "
            "near which the search for the period doubling began"
        )
    options = BranchOptions(
        vary=f"{result.name}={result.low!r}:{result.high!r}",
        origin=result.origin,
        doubled=result.doubled,
    )
    return command_for("branch", result, options)


def _is_start_known(result: "CycleBranch") -> bool:
    # Whether the scene's value of the varied parameter is known, or makes no difference. Printed
    # files lack it, and that of the first point replaces it. It selects one of the Hopf points.
    if getattr(result.parameters, result.name) != result.points[0].value:
        return True
    hopf_points = hopf.hopf_values(result.system, result.name, result.low, result.high)
    return result.origin == "hopf" and len(hopf_points) == 1


# Limit cycles along a parameter, stable and unstable, connected by continuation.
BRANCH: Final = StudyKind(
    contents_name="branch",
    show=report.print_branch,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"branch-{result.name}",
    header_keys=frozenset({"event_kinds"}),
    json_keys=frozenset({"parameter", "points", "events"}),
    load=branch_files.restore_branch,
    command=_branch_command,
    # The laboratory's file also has the set's value of the parameter that varies; both are read
    # alike.
    storage=Storage(
        suffix=".json", save=branch_files.store_branch, load=branch_files.restore_branch
    ),
)

BOUNDARY: Final = StudyKind(
    contents_name="boundary",
    show=report.print_boundary,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"{result.kind}-{'-'.join(result.names)}",
    header_keys=frozenset({"curve_events"}),
    json_keys=frozenset({"curve", "over", "curves"}),
)

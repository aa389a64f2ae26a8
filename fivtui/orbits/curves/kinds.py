"""Entry of branches of limit cycles in the registry of studies."""

from typing import TYPE_CHECKING, Final

from fivtui.lazy import lazy_modules
from fivtui.model import InputError
from fivtui.orbits.options import BranchOptions
from fivtui.results import TABLE_SUFFIXES, Command, Storage, StudyKind, command_for

if TYPE_CHECKING:
    from .result import CycleBranch

files, report = lazy_modules(__name__, "files", "report")


def _command(result: "CycleBranch") -> Command:
    if result.origin == "file" or result.doubled:
        raise InputError("branch: no command repeats it: no option gives the cycle it begins at")
    vary = f"{result.name}={result.low!r}:{result.high!r}"
    return command_for("branch", result, BranchOptions(vary=vary, origin=result.origin))


BRANCH: Final = StudyKind(
    data="branch",
    show=report.print_branch,
    suffixes=TABLE_SUFFIXES,
    as_json=True,
    stem=lambda result: f"branch-{result.name}",
    header=frozenset({"event_kinds"}),
    json_keys=frozenset({"parameter", "points", "events"}),
    load=files.restore_branch,
    command=_command,
    stored=Storage(".json", files.store_branch, files.restore_branch),
)

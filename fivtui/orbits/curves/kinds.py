"""Branches of limit cycles among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.io import FORMATS
from fivtui.model import InputError
from fivtui.results import Command, Stored, StudyKind, save_result

if TYPE_CHECKING:
    from . import files, report
    from .result import CycleBranch
else:
    from fivtui.lazy import later

    files, report = later(__name__, "files", "report")

_FORMATS: Final = tuple(FORMATS)


def _command(result: "CycleBranch") -> Command:
    if result.origin == "file" or result.doubled:
        raise InputError("branch: no option says the cycle that it was begun with")
    fields = {"parameters": result.parameters, "separation": result.separation}
    words = ["--vary", f"{result.name}={result.low!r}:{result.high!r}", "--from", result.origin]
    return Command("branch", fields, words=words)


BRANCH: Final = StudyKind(
    data="branch",
    show=report.print_branch,
    suffixes=_FORMATS,
    save=save_result,
    as_json=True,
    stem=lambda result: f"branch-{result.name}",
    header=frozenset({"event_kinds"}),
    json_keys=frozenset({"parameter", "points", "events"}),
    load=files.restore_branch,
    load_suffixes=(".json",),
    command=_command,
    stored=Stored(".json", files.store_branch, files.restore_branch),
)

"""Arguments and options that commands share, and how their values are read."""

import json
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fivtui.model import (
    InputError,
    describe_unused,
    unused_parameters,
)
from fivtui.options import OUTPUT

from .arguments import option
from .paths import OutputFile, OutputFolder

if TYPE_CHECKING:
    from fivtui.console import ProgressBar
    from fivtui.scene import Scene

# Warnings about the input, printed when the computation begins.
_WARNINGS: Final[list[str]] = []

json_option = option(
    "--json", "as_json", is_flag=True, group=OUTPUT, help="Print the result as one JSON object."
)
force_option = option("--force", is_flag=True, group=OUTPUT, help="Overwrite files that exist.")


def output_option(
    flag: str, metavar: str, text: str, *, required: bool = False, in_parts: bool = False
) -> Callable[..., Any]:
    """An option for a file; with `in_parts`, pieces are stored beside it until it is complete."""
    kind = OutputFile(in_parts=in_parts)
    return option(flag, type=kind, metavar=metavar, help=text, required=required, group=OUTPUT)


def folder_option(text: str) -> Callable[..., Any]:
    """The option --out for a folder."""
    folder = OutputFolder()
    return option("--out", type=folder, metavar="DIR", help=text, required=True, group=OUTPUT)


def warn_of_unused_parameters(
    scene: "Scene", varied: Sequence[str] = (), assignments: Sequence[str] = ()
) -> None:
    """Warn of parameters that have a value but no effect, unless the command is refused.

    `varied` are texts such as ``F=10:120:23`` or ``F~normal:80:8``. `assignments`, the texts of
    ``--set``, have no effect if their parameter varies.
    """
    names = [text.replace("~", "=").partition("=")[0].strip() for text in varied]
    for overridden in (
        name for name in parse_assignments("--set", assignments, "F=120") if name in names
    ):
        _WARNINGS.append(f"--set {overridden} has no effect: {overridden} varies")
    names += [name for name, _ in scene.over_time]
    unused = unused_parameters(scene.parameters, names)
    # No warning if a varied parameter has no effect: the computation will refuse it.
    if unused and not {*unused} & {*names}:
        _WARNINGS.append(describe_unused(scene.parameters, names))


def parse_error_targets(assignments: Sequence[str]) -> dict[str, float]:
    """Error targets by quantity, from the texts of ``--error``."""
    from fivtui.transient import check_accuracy

    return check_accuracy(parse_assignments("--error", assignments, "peak=1e-4"))


def parse_assignments(flag: str, assignments: Sequence[str], example: str) -> dict[str, str]:
    """Values by name, from the texts ``NAME=VALUE`` of an option."""
    values: dict[str, str] = {}
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{flag} {assignment}: must be NAME=VALUE, e.g. {flag} {example}")
        if name.strip() in values:
            raise InputError(f"{flag} {name.strip()}=…: given twice; every name must be given once")
        values[name.strip()] = text.strip()
    return values


def print_json(data: Any) -> None:
    """Print data as JSON to standard output."""
    ascii_only = "utf" not in (sys.stdout.encoding or "").lower()
    print_text(json.dumps(data, ensure_ascii=ascii_only, allow_nan=False, indent=2))


def print_text(text: str) -> None:
    """Print lines of data to standard output."""
    sys.stdout.write(f"{text}\n")


def print_note(message: str) -> None:
    """Print a note to standard error."""
    sys.stderr.write(f"{message}\n")


def print_warnings() -> None:
    """Print the pending warnings to standard error."""
    while _WARNINGS:
        print_note(f"warning: {_WARNINGS.pop(0)}")


def drop_warnings() -> None:
    """Drop the pending warnings."""
    _WARNINGS.clear()


def print_written_files(*paths: Path, note: str = "") -> None:
    """Print which files were written, and in which folder, with a `note`."""
    from fivtui.io import describe_files

    ending = f": {note}" if note else ""
    print_note(f"wrote {describe_files(*paths)}{ending}")


def progress_bar(label: str) -> "ProgressBar":
    """Print pending warnings, and return a progress bar.

    Before the first one, a note tells if runs are interpreted: without the kernel, the integrator
    in C, Python integrates.
    """
    from fivtui.console import ProgressBar

    print_warnings()
    _warn_if_interpreted()
    return ProgressBar(label)


@cache
def _warn_if_interpreted() -> None:
    from fivtui.kernel import why_interpreted

    reason = why_interpreted()
    if reason is not None:
        print_note(f"Runs are interpreted, which takes about a hundred times as long: {reason}")

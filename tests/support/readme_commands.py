"""Runs the README's blocks in order, in this folder and process; packages of extras are hidden."""

import contextlib
import io
import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from importlib.metadata import packages_distributions, requires
from typing import Any, Final, NamedTuple

import pytest

from fivtui.cli import run
from fivtui.orbits.curves.following import Follower
from fivtui.scene import Scene, comparison

# Extras that the test process itself needs stay visible.
_TEST_EXTRAS: Final = ("test", "dev")
# Reduced numbers of values of a range, of samples, and of points of a branch.
_RANGE_VALUES, _SAMPLES, _BRANCH_POINTS = 2, 16, 6
# Starts of a search: heights above the equilibrium, in characteristic lengths.
_SEARCH_OFFSETS: Final = (1e-3, 1.0, 30.0)
# Horizon of compared runs, s, and CPU time of a trade-off, s.
_COMPARED_S, _TRADEOFF_S = 20.0, 0.2
# A range of a parameter: NAME=LOW:HIGH:COUNT.
_RANGE: Final = re.compile(r"^(\w+=[^:]+:[^:]+):(\d+)")


class Printed(NamedTuple):
    """Result of a command or script: exit status, standard output, standard error."""

    line: str
    code: int | None
    out: str
    error: str


@cache
def _packages_of_extras() -> frozenset[str]:
    extras = {
        re.split(r"[^A-Za-z0-9-]", text)[0].lower()
        for text in requires("fivtui") or ()
        if (extra := re.search(r"extra == .(\w+)", text)) and extra[1] not in _TEST_EXTRAS
    }
    return frozenset(
        package
        for package, distributions in packages_distributions().items()
        if extras.intersection(name.lower() for name in distributions)
    )


def hide_extras(patch: pytest.MonkeyPatch) -> None:
    """Hide packages that only extras install."""
    for package in _packages_of_extras():
        patch.setitem(sys.modules, package, None)


def shorten_comparisons(patch: pytest.MonkeyPatch) -> None:
    """Shorten comparisons and trade-offs without an explicit duration."""
    patch.setattr("fivtui.tradeoffs.measure.QUICK_S", _TRADEOFF_S)
    run_case = comparison._case_runs

    def run_shorter(scene: Scene, *rest: Any) -> Any:
        return run_case(replace(scene, t_end=_COMPARED_S), *rest)

    patch.setattr(comparison, "_case_runs", run_shorter)


def shorten_searches(patch: pytest.MonkeyPatch) -> None:
    """End branches after a few points, and search cycles from few starts."""
    defaults = Follower.__init__.__kwdefaults__
    assert defaults is not None
    assert "max_points" in defaults
    patch.setitem(defaults, "max_points", _BRANCH_POINTS)
    patch.setattr("fivtui.orbits.explorer._OFFSETS", _SEARCH_OFFSETS)


def reduced(arguments: list[str]) -> list[str]:
    """A command with fewer points and samples."""
    shorter = [
        _RANGE.sub(lambda match: f"{match[1]}:{min(int(match[2]), _RANGE_VALUES)}", argument)
        for argument in arguments
    ]
    for index, argument in enumerate(arguments[:-1]):
        if argument == "--samples":
            shorter[index + 1] = str(_SAMPLES)
    return shorter


def commands_of(text: str) -> list[list[str]]:
    """The fivtui commands in a block of shell lines, including those after an installation."""
    commands = [shlex.split(part) for line in text.splitlines() for part in line.split("&&")]
    return [
        command[1:] for command in commands if command[0].removeprefix(".venv/bin/") == "fivtui"
    ]


def _printed(line: str, action: Callable[[], int | None]) -> Printed:
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        code = action()
    return Printed(line, code, out.getvalue(), error.getvalue())


def run_blocks(
    blocks: list[tuple[str, str]], change: Callable[[list[str]], list[str]] = list
) -> list[Printed]:
    """Results of blocks, pairs of language and text.

    `change` modifies commands before they run; the default, `list`, only copies them.
    """
    printed = []
    for language, text in blocks:
        if language == "sh":
            for command in commands_of(text):
                arguments = change(command)
                line = shlex.join(["fivtui", *arguments])
                printed.append(_printed(line, partial(run, arguments)))
        else:
            printed.append(_printed(language, partial(exec, text, {"__name__": "__main__"})))
    return printed

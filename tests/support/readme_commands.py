"""Run the README's blocks in order, in this folder and process, without the packages of extras.

Standard input has the blocks as JSON pairs of language and text; standard output what came of them.
"""

import contextlib
import io
import json
import re
import shlex
import sys
from importlib.metadata import packages_distributions, requires
from typing import Any

from fivtui.cli import run


def hide_extras() -> None:
    """Have the packages that extras alone install be missing."""
    extras = {
        re.split(r"[^A-Za-z0-9-]", text)[0].lower()
        for text in requires("fivtui") or ()
        if "extra ==" in text
    }
    for package, distributions in packages_distributions().items():
        if extras.intersection(name.lower() for name in distributions):
            sys.modules[package] = None  # type: ignore[assignment]


def commands_of(text: str) -> list[list[str]]:
    """The commands of fivtui in a block of shell lines, those after an installation too."""
    words = [shlex.split(part) for line in text.splitlines() for part in line.split("&&")]
    return [command[1:] for command in words if command[0].removeprefix(".venv/bin/") == "fivtui"]


def outcome(action: Any) -> dict[str, Any]:
    """What an action gives back and prints."""
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        code = action()
    return {"code": code, "out": out.getvalue(), "error": error.getvalue()}


def main() -> None:
    """Run what standard input says."""
    hide_extras()
    from fivtui.tradeoffs import measure

    # A second of measuring has all methods; how fine they get is tested elsewhere.
    measure.QUICK_S = 1.0  # type: ignore[misc]
    found = []
    for language, text in json.load(sys.stdin):
        if language == "sh":
            for words in commands_of(text):
                said = outcome(lambda words=words: run(words))
                found.append({"line": shlex.join(["fivtui", *words]), **said})
        else:
            said = outcome(lambda text=text: exec(text, {"__name__": "__main__"}))
            found.append({"line": language, **said})
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()

"""The documentation that the FMU carries: its variables, its rules, and the licences."""

import html
from importlib.metadata import distribution
from pathlib import Path
from typing import Final

from .variable import Role
from .variables import VARIABLES

_TITLES: Final = {
    Role.PARAMETER: "Parameters, fixed once the run has begun",
    Role.INPUT: "Inputs, held from one communication point to the next",
    Role.OUTPUT: "Outputs",
    Role.LOCAL: "Local variables",
}
_RULES: Final = """\
<p>State events (separation and reattachment at y = 0) are located inside a communication step to
rounding. Results do not depend on the communication step. An event is counted at the first
communication point that is not before it.</p>
<p>The relative tolerance of the experiment is the relative error to expect of the state after about
a hundred periods.</p>
<p>What is refused (a value out of its range, a fixed parameter while stepping, a wrong time) is
logged and changes nothing; the next step then returns fmi2Discard.</p>
<p>The FMU needs Python 3.11 or newer in the process that loads it. The path to which it is
extracted may hold ASCII letters, digits and spaces, but no # and no %.</p>
"""


def documentation() -> dict[str, bytes]:
    """The files below ``documentation/``.

    Returns
    -------
    dict of str to bytes
        Content by name in the FMU.
    """
    return {
        "documentation/index.html": _index().encode(),
        "documentation/licenses/pythonfmu.txt": _license_of("pythonfmu"),
    }


def _index() -> str:
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        "<title>SliderBelt</title></head><body>\n<h1>SliderBelt</h1>\n",
        _RULES,
    ]
    for role, title in _TITLES.items():
        rows = "".join(
            f"<tr><td>{v.name}</td><td>{v.unit}</td><td>{html.escape(v.meaning)}</td>"
            f"<td>{html.escape(v.allowed)}</td></tr>\n"
            for v in VARIABLES
            if v.role is role
        )
        parts.append(f"<h2>{title}</h2>\n<table>\n{rows}</table>\n")
    return "".join(parts) + "</body></html>\n"


def _license_of(package: str) -> bytes:
    for file in distribution(package).files or ():
        if file.name == "LICENSE":
            return Path(str(file.locate())).read_bytes()
    raise LookupError(f"the installed {package} has no licence file")

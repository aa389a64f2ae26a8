"""The documentation in an FMU: its variables, its rules, and the licences."""

import html
from importlib.metadata import distribution
from pathlib import Path
from typing import Final

from fmu_src.slave import Role

from .component import Component

_TITLES: Final = {
    Role.PARAMETER: "Parameters, fixed once the run has begun",
    Role.INPUT: "Inputs, held from one communication point to the next",
    Role.OUTPUT: "Outputs",
    Role.LOCAL: "Local variables",
}


def documentation(component: Component) -> dict[str, bytes]:
    """The files below ``documentation/``: content by name in the FMU."""
    return {
        "documentation/index.html": _index(component).encode(),
        f"documentation/licenses/{component.wrapper}.txt": _license_of(component.wrapper),
    }


def _index(component: Component) -> str:
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f"<title>{component.model}</title></head><body>\n<h1>{component.model}</h1>\n",
        component.about,
        component.rules,
    ]
    for role, title in _TITLES.items():
        rows = "".join(
            f"<tr><td>{v.name}</td><td>{v.unit}</td><td>{html.escape(v.meaning)}</td>"
            f"<td>{html.escape(v.allowed)}</td></tr>\n"
            for v in component.table.variables
            if v.role is role
        )
        parts.append(f"<h2>{title}</h2>\n<table>\n{rows}</table>\n" if rows else "")
    return "".join(parts) + "</body></html>\n"


def _license_of(package: str) -> bytes:
    for file in distribution(package).files or ():
        if file.name == "LICENSE":
            return Path(str(file.locate())).read_bytes()
    raise LookupError(f"the installed {package} has no licence file")

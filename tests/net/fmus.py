"""The XML of every variant of the FMU."""

import tempfile
import zipfile
from pathlib import Path
from typing import Final

from fivtui import build_fmu
from tests.net.files import xml_lines
from tests.net.text import SECTION_MARK

# Component, version of FMI, flavour. Native FMUs support co-simulation and model exchange.
VARIANTS: Final = (
    ("slider-belt", "2", "python"),
    ("slider-belt", "2", "native"),
    ("slider-belt", "3", "native"),
    ("brake-actuator", "2", "python"),
    ("brake-actuator", "2", "native"),
    ("brake-actuator", "3", "native"),
)


def record_fmus() -> str:
    """All XML files of every variant."""
    lines = []
    with tempfile.TemporaryDirectory(prefix="fivtui-net-") as folder:
        for component, fmi, flavour in VARIANTS:
            path = build_fmu(
                Path(folder) / f"{component}-{fmi}-{flavour}.fmu",
                component=component,
                fmi=fmi,
                flavour=flavour,
                sources=flavour == "native",
            )
            with zipfile.ZipFile(path) as archive:
                for name in sorted(archive.namelist()):
                    if name.endswith(".xml"):
                        lines.append(f"{SECTION_MARK}{path.name}: {name}")
                        lines += xml_lines(archive.read(name).decode())
    return "\n".join(lines) + "\n"

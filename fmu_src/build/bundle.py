"""The Python sources that an FMU contains, in a package with a unique name.

Modules of the same name collide in an interpreter that hosts several FMUs, so the package is named
by a hash of its content.
"""

import hashlib
import re
import threading
from dataclasses import dataclass
from importlib.resources import files
from pathlib import PurePosixPath
from typing import Final, Self

from .component import Component

# Held while an FMU's Python code is imported: importing changes `sys.path` and `sys.modules`.
IMPORT_LOCK: Final = threading.Lock()
_PROJECT_IMPORT: Final = re.compile(r"^from (?=(?:fivtui|fmu_src)[. ])", re.MULTILINE)
_HASH_DIGITS: Final = 12


@dataclass(frozen=True, slots=True)
class Bundle:
    """The Python sources of an FMU: package, entry module, and texts by path in the resources."""

    package: str
    entry: str
    sources: dict[str, str]

    @classmethod
    def from_component(cls, component: Component) -> Self:
        """Collect the bundle of a component from the installed sources; equal for equal sources."""
        texts = {
            f"{package.replace('.', '/')}/{name}.py": _read_source(package, name)
            for package, names in component.modules.items()
            for name in names
        }
        entry_text = _read_source("fmu_src.slave", component.entry)
        content = "\0".join(f"{path}\0{text}" for path, text in texts.items()) + entry_text
        digest = hashlib.sha256(content.encode()).hexdigest()[:_HASH_DIGITS]
        package, entry = f"fivtui_{digest}", f"fivtui_entry_{digest}"
        sources = {
            f"{package}/{path}": _rename_imports(text, package) for path, text in texts.items()
        }
        folders = {folder for path in sources for folder in PurePosixPath(path).parents[:-1]}
        sources |= {f"{folder}/__init__.py": "" for folder in folders}
        sources[f"{entry}.py"] = _rename_imports(entry_text, package)
        return cls(package, entry, sources)


def _read_source(package: str, name: str) -> str:
    return files(package).joinpath(f"{name}.py").read_text(encoding="utf-8")


def _rename_imports(text: str, package: str) -> str:
    return _PROJECT_IMPORT.sub(f"from {package}.", text)

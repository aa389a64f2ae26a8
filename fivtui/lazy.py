"""Names of a package that are imported on first use, so that importing it costs nothing."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_exports(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Functions `__getattr__` and `__dir__` of a package that import its exports on first use.

    Its exports are the names that its ``__init__.py`` imports under ``if TYPE_CHECKING``.
    """
    module_names: dict[str, str] = {}

    def load_module_names() -> dict[str, str]:
        if not module_names:
            module_names.update(_read_modules(Path(str(sys.modules[package].__file__))))
        return module_names

    def import_export(name: str) -> object:
        if name not in load_module_names():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(module_names[name], package), name)
        setattr(sys.modules[package], name, value)
        return value

    return import_export, lambda: sorted(load_module_names())


class LazyModule:
    """A module that is imported when one of its functions is called."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*args: Any, **kwargs: Any) -> Any:
            return getattr(import_module(self._module), name)(*args, **kwargs)

        return call


def lazy_modules(importer: str, *names: str) -> tuple[LazyModule, ...]:
    """Modules beside `importer`, by name; each is imported when one of its functions is called."""
    package = importer.rpartition(".")[0]
    return tuple(LazyModule(f"{package}.{name}") for name in names)


def _read_modules(path: Path) -> dict[str, str]:
    # The module of each name that a file imports under `if TYPE_CHECKING`.
    for block in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING":
            return {
                alias.name: "." * statement.level + (statement.module or "")
                for statement in block.body
                if isinstance(statement, ast.ImportFrom)
                for alias in statement.names
            }
    return {}

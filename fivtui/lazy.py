"""Names of a package that are imported on first use, so that importing it costs nothing."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazily(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Functions `__getattr__` and `__dir__` for a package."""
    module_names: dict[str, str] = {}

    def exported() -> dict[str, str]:
        if not module_names:
            module_names.update(_read_modules(Path(str(sys.modules[package].__file__))))
        return module_names

    def get(name: str) -> object:
        if name not in exported():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(module_names[name], package), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted(exported())


class Later:
    """The functions of a module, which is imported when one of them is called."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*positional: Any, **named: Any) -> Any:
            return getattr(import_module(self._module), name)(*positional, **named)

        return call


def later(user: str, *names: str) -> tuple[Later, ...]:
    """Siblings of the module `user`, by name, imported when one of their functions is called."""
    package = user.rpartition(".")[0]
    return tuple(Later(f"{package}.{name}") for name in names)


def _read_modules(path: Path) -> dict[str, str]:
    # The module of each name that a file imports for type checkers.
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING":
            return {
                alias.name: "." * line.level + (line.module or "")
                for line in statement.body
                if isinstance(line, ast.ImportFrom)
                for alias in line.names
            }
    return {}

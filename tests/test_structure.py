"""The layout of the sources: contracts that refuse, names, folders, who knows which package."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any, Final

import pytest

import fivtui

ROOT: Final = Path(__file__).parents[1]
PACKAGES: Final = ("fivtui", "fmu_src")
SOURCES: Final = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}
CHILDREN: Final = {name.split(".")[1] for name in SOURCES if name.startswith("fivtui.")}
CONTRACTS: Final[list[dict[str, Any]]] = tomllib.loads(
    (ROOT / "pyproject.toml").read_text(encoding="utf-8")
)["tool"]["importlinter"]["contracts"]

# For each contract an import that it must refuse: who imports, and what.
VIOLATIONS: Final = {
    "Layers of fivtui": ("fivtui.transient.rk4", "fivtui.orbits.decay"),
    "Layers of the laboratory": ("fivtui.tui.session.history", "fivtui.tui.tabs.messages"),
    "What the Python FMU carries imports the standard library alone": (
        "fivtui.taylor.polynomial",
        "numpy",
    ),
    "The FMU's slave sees the model and the Taylor integrator alone": (
        "fmu_src.slave.motion",
        "fivtui.io.files",
    ),
    "The FMU's builder sees files and kernel beside that, never its hosts": (
        "fmu_src.build.bundle",
        "fivtui.fmu.folders",
    ),
    "The independent RK4 shares no stepping code with the Taylor integrator": (
        "fivtui.transient.rk4",
        "fivtui.taylor.stepper",
    ),
    "Textual is known to the screens alone": ("fivtui.tui.persistence.slots", "textual"),
    "click is known to the command line alone": ("fivtui.sweeps.request", "click"),
    "matplotlib is known to figures alone": ("fivtui.batch.result", "matplotlib"),
}
# The children of fivtui that a contract of one package leaves free to import it.
FREE: Final = {
    "textual": {"__main__", "tui", "version"},
    "click": {"__main__", "cli", "version"},
    "matplotlib": {
        "__main__",
        "cli",
        "equilibrium",
        "orbits",
        "paper",
        "plotting",
        "sweeps",
        "tradeoffs",
        "transient",
        "tui",
        "version",
    },
}


def lint_imports(root: Path) -> str:
    """What import-linter prints of the sources in a folder."""
    code = "import sys; from importlinter.cli import lint_imports_command as c; sys.exit(c())"
    done = subprocess.run(
        [sys.executable, "-c", code, "--no-cache", "--no-logo"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def sections(report: str) -> dict[str, str]:
    """What a report says of each broken contract, by its name."""
    parts = re.split(r"^(.+)\n-+\n", report, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_each_contract_refuses_an_import_planted_against_it(tmp_path: Path) -> None:
    for package in PACKAGES:
        shutil.copytree(
            ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    assert f"Contracts: {len(CONTRACTS)} kept, 0 broken." in lint_imports(tmp_path)
    for importer, imported in VIOLATIONS.values():
        path = tmp_path / SOURCES[importer].relative_to(ROOT)
        with path.open("a", encoding="utf-8") as file:
            file.write(f"\nimport {imported}\n")
    (tmp_path / "fivtui" / "unplaced.py").write_text("", encoding="utf-8")
    found = sections(lint_imports(tmp_path))
    assert list(VIOLATIONS) == [contract["name"] for contract in CONTRACTS]
    for name, (importer, imported) in VIOLATIONS.items():
        assert f"{name} BROKEN" in "".join(found.values())
        assert f"{importer} -> {imported} (l." in found[name], name
    assert "unplaced" in found["Layers of fivtui"]


@pytest.mark.parametrize("package", FREE)
def test_the_contract_of_a_package_has_every_other_child_of_fivtui(package: str) -> None:
    (contract,) = (one for one in CONTRACTS if one.get("forbidden_modules") == [package])
    held = {name.removeprefix("fivtui.") for name in contract["source_modules"]}
    assert held & CHILDREN == CHILDREN - FREE[package]


def test_no_module_bears_the_name_of_an_exported_function() -> None:
    assert not CHILDREN.intersection(fivtui.__all__)


IN_ORDER: Final = """
import random, sys
from importlib import import_module

seed, *modules = sys.argv[1:]
random.Random(int(seed)).shuffle(modules)
for module in modules:
    import_module(module)
import fivtui
for name in fivtui.__all__:
    value = getattr(fivtui, name)
    assert type(value) is not type(sys), name
    assert getattr(value, "__name__", name) == name
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_modules_are_imported_in_any_order_and_hide_no_function(seed: int) -> None:
    # Importing a compiled kernel compiles it; `__main__` starts a program.
    chosen = [
        name
        for name in SOURCES
        if not name.startswith("fivtui.kernel.") and not name.endswith("__main__")
    ]
    done = subprocess.run(
        [sys.executable, "-c", IN_ORDER, str(seed), *chosen],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_of_modules_says_in_a_line_what_it_is(package: str) -> None:
    folders = {path.parent for path in (ROOT / package).rglob("*.py")}
    for folder in folders:
        docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8")))
        assert docstring, folder
        assert docstring.splitlines()[0].endswith("."), folder


def test_the_rules_of_git_and_of_the_wheel_leave_out_no_module(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        check=True,
    )
    (wheel,) = tmp_path.iterdir()
    shutil.unpack_archive(wheel, tmp_path / "wheel", "zip")
    missing = [
        name
        for name, path in SOURCES.items()
        if not (tmp_path / "wheel" / path.relative_to(ROOT)).is_file()
    ]
    assert not missing


@cache
def imported_by(path: Path) -> set[str]:
    """The packages that a module imports, at its head or later, but for type checkers alone."""
    found: set[str] = set()
    waiting: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            found.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
            found.add(node.module.partition(".")[0])
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
        elif isinstance(node, ast.mod | ast.stmt | ast.ExceptHandler | ast.match_case):
            waiting += ast.iter_child_nodes(node)
    return found


# The modules that know a package, as a regular expression.
KNOWN_TO: Final = {
    "click": r"fivtui\.cli(\..+)?",
    "distributed": r"fivtui\.sweeps\.cluster",
    "fmpy": r"fivtui\.fmu\..+|fmu_src\.build\..+",
    "matplotlib": r"fivtui\.(plotting|\w+\.figure|paper\.drawing|tui\.tabs\.chart_figure)",
    "numba": r"fivtui\.kernel\..+",
    "rich": r"fivtui\.(console\..+|(\w+\.)+report|tui\.(chart\.widget|lab|tabs)\..+)",
    "textual": r"fivtui\.tui\.(app|lab\..+|tabs\.(?!charts\b).+|chart\.widget\..+)",
    "textual_serve": r"fivtui\.tui\.serve",
    "tomlkit": r"fivtui\.scene\.scene",
}


@pytest.mark.parametrize("package", KNOWN_TO)
def test_a_package_is_known_to_its_modules_alone(package: str) -> None:
    knowing = [name for name, path in SOURCES.items() if package in imported_by(path)]
    assert knowing
    assert not [name for name in knowing if not re.fullmatch(KNOWN_TO[package], name)]


def test_what_the_python_fmu_carries_imports_the_standard_library_and_its_wrapper() -> None:
    walled = re.compile(r"fivtui\.(model|taylor)(\..+)?|fmu_src\.slave(\..+)?")
    known = {*sys.stdlib_module_names, *PACKAGES, "pythonfmu", "pythonfmu3"}
    assert not {
        name: imported_by(path) - known
        for name, path in SOURCES.items()
        if walled.fullmatch(name) and imported_by(path) - known
    }

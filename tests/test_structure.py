"""The layout of the sources: import contracts, names, folders, and packages by importer.

The laboratory is the terminal interface, `fivtui.tui`. The slave is the code inside an FMU.
"""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from functools import cache
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from typing import Any, Final

import pytest

import fivtui
from tests.support.processes import run_python

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

# For each contract an import that it must refuse: importer and imported module.
VIOLATIONS: Final = {
    "Layers of fivtui": ("fivtui.transient.steppers.rk4", "fivtui.orbits.decay"),
    "Layers of the laboratory": ("fivtui.tui.session.editing", "fivtui.tui.tabs.messages"),
    "What the Python FMU carries imports the standard library alone": (
        "fivtui.taylor.polynomial",
        "numpy",
    ),
    "The FMU's slave sees the model and the Taylor integrator alone": (
        "fmu_src.slave.motion",
        "fivtui.io.files",
    ),
    "The FMU's builder sees files and kernel, but nothing that runs an FMU": (
        "fmu_src.build.builder",
        "fivtui.fmu.folders",
    ),
    "The independent RK4 shares no stepping code with the Taylor integrator": (
        "fivtui.transient.steppers.rk4",
        "fivtui.taylor.stepper",
    ),
    "Textual is known to the screens alone": ("fivtui.tui.persistence.slots", "textual"),
    "click is known to the command line alone": ("fivtui.sweeps.options", "click"),
    "matplotlib is known to figures alone": ("fivtui.batch.result", "matplotlib"),
}
# Children of fivtui that may import a package which a contract forbids to all others.
ALLOWED_CHILDREN: Final = {
    "textual": {"__main__", "tui", "lazy", "version"},
    "click": {"__main__", "cli", "lazy", "version"},
    "matplotlib": {
        "__main__",
        "charts",
        "cli",
        "equilibrium",
        "film",
        "maps",
        "measured",
        "orbits",
        "paper",
        "reliability",
        "results",
        "safety",
        "sweeps",
        "tradeoffs",
        "transient",
        "tui",
        "lazy",
        "version",
    },
}


def lint_imports(root: Path) -> str:
    """Output of import-linter for the sources in a folder."""
    code = "import sys; from importlinter.cli import lint_imports_command as c; sys.exit(c())"
    process = subprocess.run(
        [sys.executable, "-c", code, "--no-cache", "--no-logo"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode in (0, 1), process.stderr
    return process.stdout


def reports_by_contract(report: str) -> dict[str, str]:
    """The report on each broken contract, by contract."""
    parts = re.split(r"^(.+)\n-+\n", report, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_each_contract_refuses_a_forbidden_import(tmp_path: Path) -> None:
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
    reports = reports_by_contract(lint_imports(tmp_path))
    assert list(VIOLATIONS) == [contract["name"] for contract in CONTRACTS]
    for name, (importer, imported) in VIOLATIONS.items():
        assert f"{name} BROKEN" in "".join(reports.values())
        assert f"{importer} -> {imported} (l." in reports[name], name
    assert "unplaced" in reports["Layers of fivtui"]


@pytest.mark.parametrize("package", ALLOWED_CHILDREN)
def test_the_contract_of_a_package_has_every_other_child_of_fivtui(package: str) -> None:
    (contract,) = (
        candidate for candidate in CONTRACTS if candidate.get("forbidden_modules") == [package]
    )
    modules = {name.removeprefix("fivtui.") for name in contract["source_modules"]}
    assert modules & CHILDREN == CHILDREN - ALLOWED_CHILDREN[package]


def test_no_module_has_the_name_of_an_exported_function() -> None:
    assert not CHILDREN.intersection(fivtui.__all__)


# Importers use modules of these packages directly: the FMU contains single modules without the
# packages' exports, and the kernel is generated from the model's modules.
DIRECTLY_IMPORTED: Final = {"fivtui.model", "fivtui.taylor", "fivtui.kernel", "fmu_src.slave"}


@cache
def syntax_tree(path: Path) -> ast.Module:
    """Syntax tree of a module, cached for all tests."""
    return ast.parse(path.read_text(encoding="utf-8"))


def is_package(name: str) -> bool:
    return SOURCES[name].name == "__init__.py"


def package_of(name: str) -> str:
    """The package that a module belongs to: a child of fivtui, fivtui.tui or fmu_src."""
    parts = name.split(".") if is_package(name) else name.split(".")[:-1]
    return ".".join(parts[: 3 if parts[:2] == ["fivtui", "tui"] else 2])


@cache
def imported_names(name: str) -> list[tuple[str, str]]:
    """Module and name of each import from the project's own modules."""
    package = name if is_package(name) else name.rpartition(".")[0]
    imports = []
    for node in ast.walk(syntax_tree(SOURCES[name])):
        if isinstance(node, ast.ImportFrom):
            module = resolve_name("." * node.level + (node.module or ""), package)
            imports += [(module, alias.name) for alias in node.names if module in SOURCES]
    return imports


def exported_names(package: str) -> set[str]:
    return set(dir(import_module(package)))


def needs_export(importer: str, module: str) -> bool:
    """Whether `importer` may import only exported names from `module`, of another package."""
    package, imported_package = package_of(importer), package_of(module)
    # A module directly in `fivtui`, such as `fivtui.simulation`, is in no package that exports it.
    if imported_package in (package, *PACKAGES):
        return False
    return not {package, imported_package} <= DIRECTLY_IMPORTED


def test_a_package_imports_only_exported_names_of_another() -> None:
    wrong = [
        (name, module, imported)
        for name in SOURCES
        for module, imported in imported_names(name)
        if needs_export(name, module)
        if not is_package(module) or imported not in exported_names(module)
    ]
    assert not wrong


def test_every_name_that_a_package_exports_is_used_by_another() -> None:
    used = {
        imported for name in SOURCES for imported in imported_names(name) if imported[0] != name
    }
    unused = {
        (package, name)
        for package in SOURCES
        if is_package(package) and package not in ("fivtui", "fivtui.cli")
        # `dir` lists exports alone if they are lazy, imported on first use; else also submodules.
        if "lazy_exports" in SOURCES[package].read_text(encoding="utf-8")
        for name in exported_names(package)
        if (package, name) not in used
    }
    assert not unused


def test_an_unknown_name_of_a_package_is_refused_as_python_does_it() -> None:
    batch = import_module("fivtui.batch")
    with pytest.raises(AttributeError, match=r"module 'fivtui\.batch' has no attribute 'nothing'"):
        batch.nothing  # noqa: B018
    with pytest.raises(ImportError, match="cannot import name 'nothing'"):
        exec("from fivtui.batch import nothing")


def test_rk4_imports_only_the_segment_type_from_taylor() -> None:
    imports = {
        imported
        for name in ("fivtui.transient.steppers.rk4", "fivtui.transient.trajectory")
        for imported in imported_names(name)
        if imported[0].startswith("fivtui.taylor")
    }
    assert imports == {("fivtui.taylor", "Segment")}


IMPORT_ALL: Final = """
import random, sys
from importlib import import_module

seed, *modules = sys.argv[1:]
random.Random(int(seed)).shuffle(modules)
for module in modules:
    import_module(module)
# An imported submodule becomes an attribute of its package, which hides an exported function of the
# same name. Packages with lazy exports have `__dir__`.
for package in modules:
    module = sys.modules[package]
    for name in dir(module) if "__dir__" in vars(module) else []:
        assert type(getattr(module, name)) is not type(sys), (package, name)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.whole) for seed in range(2, 9))]
)
def test_modules_can_be_imported_in_any_order_and_hide_no_function(seed: int) -> None:
    # `__main__` starts a program.
    chosen = [name for name in SOURCES if not name.endswith("__main__")]
    run_python("-c", IMPORT_ALL, seed, *chosen)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_package_has_a_docstring(package: str) -> None:
    folders = {path.parent for path in (ROOT / package).rglob("*.py")}
    for folder in folders:
        docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8")))
        assert docstring, folder
        assert docstring.splitlines()[0].endswith("."), folder


# Without a compiler the build compiles nothing; CC is invalid too.
BUILD = """
import sys
sys.modules["ziglang"] = None
from hatchling.cli import hatchling
sys.exit(hatchling())
"""


def test_the_wheel_has_every_module(tmp_path: Path) -> None:
    run_python("-c", BUILD, "build", "-t", "wheel", "-d", tmp_path, environment={"CC": "none"})
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
    """Packages that a module imports anywhere, except for type checkers."""
    modules: set[str] = set()
    pending: list[ast.AST] = [syntax_tree(path)]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.Import):
            modules.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
            modules.add(node.module.partition(".")[0])
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            pending += node.orelse
        elif isinstance(node, ast.mod | ast.stmt | ast.ExceptHandler | ast.match_case):
            pending += ast.iter_child_nodes(node)
    return modules


# Modules that may import a package, as a regular expression.
ALLOWED_IMPORTERS: Final = {
    "click": r"fivtui\.cli(\..+)?",
    "distributed": r"fivtui\.sweeps\.cluster",
    "fmpy": r"fivtui\.fmu\..+|fmu_src\.build\..+",
    "matplotlib": r"fivtui\.(charts\.(displayed_charts|figure_style|sheet)|(\w+\.)+figure)",
    "rich": r"fivtui\.(console\..+|(\w+\.)+report|tui\.(chart\.widget|lab|tabs)\..+)",
    "textual": r"fivtui\.tui\.(app|lab\..+|tabs\.(?!charts\b).+|chart\.widget\..+)",
    "textual_serve": r"fivtui\.tui\.browser",
    "tomlkit": r"fivtui\.scene\.files",
}


@pytest.mark.parametrize("package", ALLOWED_IMPORTERS)
def test_a_package_is_imported_only_by_its_allowed_modules(package: str) -> None:
    importers = [name for name, path in SOURCES.items() if package in imported_by(path)]
    assert importers
    assert not [name for name in importers if not re.fullmatch(ALLOWED_IMPORTERS[package], name)]


def test_modules_in_the_python_fmu_import_only_the_standard_library_and_the_wrapper() -> None:
    carried = re.compile(r"fivtui\.(model|taylor)(\..+)?|fmu_src\.slave(\..+)?")
    allowed = {*sys.stdlib_module_names, *PACKAGES, "pythonfmu"}
    assert not {
        name: imported_by(path) - allowed
        for name, path in SOURCES.items()
        if carried.fullmatch(name) and imported_by(path) - allowed
    }


def test_no_folder_has_more_than_16_modules() -> None:
    modules = Counter(path.parent for path in SOURCES.values() if path.name != "__init__.py")
    assert max(modules.values()) <= 16


def test_no_two_classes_have_the_same_name() -> None:
    classes = Counter(
        node.name
        for path in SOURCES.values()
        for node in ast.walk(syntax_tree(path))
        if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in classes.items() if count > 1] == []


def test_the_time_limit_also_ends_tests_in_compiled_code(pytestconfig: pytest.Config) -> None:
    assert 0.0 < float(pytestconfig.getini("timeout")) <= 300.0
    # The signal method would wait until compiled code returns.
    assert pytestconfig.getini("timeout_method") == "thread"

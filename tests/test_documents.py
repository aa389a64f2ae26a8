"""Documents and comments in C name only what exists; tables of the code agree with both.

Tables are the code's dictionaries of parameters, methods, formats and packages. The laboratory, lab
in names, is the terminal interface.
"""

import ast
import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pytest

from fivtui.assessment.stress_tests import METHODS_UNDER_TEST
from fivtui.io.tables import FORMATS
from fivtui.model import System
from fivtui.model.parameters import PARAMETERS, Parameters
from fivtui.sweeps.formats import SWEEP_FORMATS
from fivtui.tradeoffs import measure, settings
from fivtui.transient import ALL_METHODS, integrate
from fivtui.transient.methods import FMU_FLAVOURS, METHODS
from fivtui.transient.request import Request
from fivtui.tui.lab.keys import LAB_KEYS
from fivtui.tui.session.fields import FIELDS
from fivtui.tui.tabs.tab_book import TABS
from fmu_src.slave.variables import VARIABLES

ROOT: Final = Path(__file__).parents[1]
TEXTS: Final = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"))
    if path.name != "CHANGELOG.md"
}
CONTRIBUTING: Final = TEXTS["CONTRIBUTING.md"]
SETTINGS: Final[dict[str, Any]] = tomllib.loads(
    (ROOT / "pyproject.toml").read_text(encoding="utf-8")
)["tool"]


def names_defined_in(path: Path) -> set[str]:
    """Names of classes, functions and constants that a module defines."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign):
            names.update(ast.unparse(target) for target in node.targets)
        elif isinstance(node, ast.AnnAssign):
            names.add(ast.unparse(node.target))
    return names


@pytest.mark.parametrize("name", TEXTS)
def test_every_path_and_module_that_is_named_exists(name: str) -> None:
    text = TEXTS[name]
    paths = {
        *re.findall(r"(?<![\w/.])(?:fivtui|fmu_src|tests|examples|docs|\.ci)/[\w./-]*", text),
        *(str(Path(name).parent / link) for link in re.findall(r"\]\((?!http)([^)#]+)\)", text)),
    }
    # A wrong regular expression would match nothing; a page of the manual may name few paths.
    assert len(paths) >= 10 or name.startswith("docs/")
    assert not [path for path in paths if not (ROOT / path).exists()]
    modules = re.findall(r"-m ((?:tests|fivtui)(?:\.\w+)*)", text)
    module_paths = [ROOT.joinpath(*module.split(".")) for module in modules]
    missing = [
        module_path
        for module_path in module_paths
        if not (module_path.with_suffix(".py").is_file() or (module_path / "__main__.py").is_file())
    ]
    assert not missing


def test_every_name_is_defined_in_the_module_named_with_it() -> None:
    pairs = re.findall(r"`(\w+)`\s+in\s+`([\w/]+\.py)`", CONTRIBUTING)
    assert len(pairs) >= 20
    assert not [(name, path) for name, path in pairs if name not in names_defined_in(ROOT / path)]


def test_every_name_in_a_comment_in_c_is_defined_in_the_module_named_with_it() -> None:
    sources = [
        path
        for folder in ("fivtui/kernel", "fmu_src/native")
        for path in sorted((ROOT / folder).glob("*.[ch]"))
    ]
    pairs = [
        (path.name, name, module)
        for path in sources
        for name, module in re.findall(
            r"`(\w+)`\s+in\s+`(fivtui[\w.]+)`", path.read_text(encoding="utf-8")
        )
    ]
    assert len(pairs) >= 10
    assert not [pair for pair in pairs if not hasattr(import_module(pair[2]), pair[1])]


def test_the_tree_in_contributing_has_every_package() -> None:
    # The tree has lines such as "    + fivtui/io/       files written atomically".
    drawn = re.findall(r"^    [ +] (fivtui/\w+)/ ", CONTRIBUTING, flags=re.MULTILINE)
    drawn += re.findall(r"`(fmu_src/\w+)/`", CONTRIBUTING)
    folders = {
        str(path.parent.relative_to(ROOT))
        for package in ("fivtui", "fmu_src")
        for pattern in ("*/__init__.py", "*/*.c")
        for path in (ROOT / package).glob(pattern)
    }
    assert sorted(drawn) == sorted(folders)


def test_the_layers_in_contributing_are_those_of_the_contracts() -> None:
    layers, tui_layers = (
        [layer.split(" | ") for layer in contract["layers"]]
        for contract in SETTINGS["importlinter"]["contracts"][:2]
    )
    rows = re.findall(r"^    ([ +]) fivtui/(\w+)(?:/|\.py) +(.*)", CONTRIBUTING, flags=re.MULTILINE)
    tree: list[list[str]] = []
    for mark, name, _ in rows:
        # A package with + is in the layer of the line above.
        if mark == "+":
            tree[-1].append(name)
        else:
            tree.append([name])
    assert [sorted(layer) for layer in tree] == [sorted(layer) for layer in layers]
    # The line of tui ends with its layers: "the laboratory: start | browser / app / lab / …".
    (tui_text,) = (text for _, name, text in rows if name == "tui")
    drawn_tui_layers = tui_text.partition(": ")[2].split(" / ")
    assert [layer.split(" | ") for layer in drawn_tui_layers] == tui_layers


def test_every_marker_is_explained() -> None:
    (paragraph,) = re.findall(r"^Markers: .*?\n\n", CONTRIBUTING, flags=re.MULTILINE | re.DOTALL)
    for marker in SETTINGS["pytest"]["ini_options"]["markers"]:
        assert f"`{marker.partition(':')[0]}`" in paragraph


def test_form_and_fmu_follow_from_the_table_of_parameters() -> None:
    assert list(FIELDS)[: len(PARAMETERS)] == list(PARAMETERS)
    assert {variable.name for variable in VARIABLES} >= set(PARAMETERS)


def test_an_added_entry_of_methods_is_a_method(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(METHODS, "added", METHODS["rk4"])
    p = Parameters()
    result = integrate(Request(System(p), t_end=1.0, method="added"))
    assert result.method == "added"
    assert result.final == integrate(Request(System(p), t_end=1.0, method="rk4")).final


def test_the_tables_of_methods_have_the_same_methods() -> None:
    assert set(ALL_METHODS) == {*METHODS, *FMU_FLAVOURS}
    # Trade-offs: the tolerances and steps of every method, and its share of the CPU time.
    assert set(ALL_METHODS) == {method for method, *_ in (*settings._TOLERANCES, *settings._STEPS)}
    assert set(ALL_METHODS) == set(measure._SHARES)
    assert FIELDS["method"].choices == ALL_METHODS
    # RK4 that steps across switches, and the native FMU, which exists only if it is compiled.
    untested = {"rk4-across", "fmu-native"}
    assert {entry.name for entry in METHODS_UNDER_TEST.values()} == set(ALL_METHODS) - untested


def test_every_format_is_written_and_read_and_its_package_is_an_extra() -> None:
    assert set(SWEEP_FORMATS) <= set(FORMATS)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for form in FORMATS.values():
        if form.package:
            (needed,) = project["optional-dependencies"][form.extra]
            assert needed.startswith(f"{form.package}>=")


def test_every_tab_has_a_key_of_its_own() -> None:
    keys = [key for binding in LAB_KEYS for key in binding.key.split(",")]
    for tab in TABS:
        assert keys.count(tab.key) == 1

"""The public API: every name, its example, and the cost of `import fivtui`."""

import doctest
import inspect
from itertools import pairwise
from pathlib import Path
from types import FunctionType

import pytest

import fivtui
from fivtui.tradeoffs import measure
from tests.support.processes import run_python

FUNCTIONS = [name for name in fivtui.__all__ if isinstance(getattr(fivtui, name), FunctionType)]
CLASSES_WITH_EXAMPLES = ["Design", "Distribution", "ProgressBar", "Range", "Scene"]
SECTIONS = ["Parameters", "Returns", "Raises", "Examples"]
# Imported only on first use.
HEAVY = ["numpy", "scipy", "matplotlib", "rich", "textual", "click", "fmpy", "tomlkit"]
WITHOUT_RESULT = ["save_scene"]


def run(code: str) -> str:
    return run_python("-c", code)


def test_dir_lists_every_public_name_and_each_exists() -> None:
    assert dir(fivtui) == sorted(fivtui.__all__)
    assert len(set(fivtui.__all__)) == len(fivtui.__all__)
    for name in fivtui.__all__:
        assert getattr(fivtui, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'simulte'"):
        fivtui.simulte  # type: ignore[attr-defined]  # noqa: B018


def test_what_the_command_line_can_do_is_public() -> None:
    assert {
        "simulate", "simulate_batch", "stability", "stability_map", "attractors", "basin",
        "boundary", "branch", "continuation", "safe_friction", "safety_map", "sweep", "tradeoff",
        "uncertainty", "accuracy", "figures", "claims", "build_fmu", "build_ssp",
        "run_fmu", "check_fmu", "animate", "sound", "read_measurement", "validate", "identify",
        "load_scene", "find_scene", "save_scene",
    } == set(FUNCTIONS)  # fmt: skip


def test_importing_the_package_imports_nothing_heavy() -> None:
    loaded = f"sorted(set(sys.modules) & set({HEAVY!r}))"
    assert run(f"import sys, fivtui; dir(fivtui); print({loaded})") == "[]\n"
    expression = "[name for name in sys.modules if name.startswith(('fivtui.', 'fmu_src'))]"
    assert run(f"import sys, fivtui; print({expression})") == "['fivtui.lazy']\n"


def test_parameters_and_errors_need_no_numpy() -> None:
    code = "from fivtui import Cancelled, ComputationError, InputError, Parameters; Parameters()"
    assert run(f"import sys; {code}; print('numpy' in sys.modules)") == "False\n"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_a_full_docstring_and_annotations(name: str) -> None:
    function = getattr(fivtui, name)
    text = inspect.getdoc(function) or ""
    lines = text.splitlines()
    headings = [line for line, rule in pairwise(lines) if set(rule) == {"-"}]
    assert headings == [
        section for section in SECTIONS if section != "Returns" or name not in WITHOUT_RESULT
    ]
    signature = inspect.signature(function)
    for parameter in signature.parameters.values():
        assert parameter.annotation is not parameter.empty
        assert parameter.name in text
    assert signature.return_annotation is not signature.empty


@pytest.mark.parametrize("name", [*FUNCTIONS, *CLASSES_WITH_EXAMPLES])
def test_the_example_of_every_public_name_is_true(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    # CPU time of a trade-off, s.
    monkeypatch.setattr(measure, "QUICK_S", 0.2)
    (test_case,) = doctest.DocTestFinder(recurse=False).find(getattr(fivtui, name), name, globs={})
    assert test_case.examples
    output: list[str] = []
    doctest.DocTestRunner(verbose=False).run(test_case, out=output.append)
    assert not output, "".join(output)

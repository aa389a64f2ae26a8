"""Every example is short and runs from anywhere."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
# All scenes that break solvers are tried by `pytest -m whole` in tests/assessment.
ARGUMENTS = {"extremes": ["lifted", "start-on-switch", "tol-too-small"]}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_runs_from_a_foreign_folder(example: Path, tmp_path: Path) -> None:
    text = example.read_text(encoding="utf-8")
    assert len(text.splitlines()) < 50
    optional = re.search(r"^from (libcosimpy)\b", text, flags=re.MULTILINE)
    if optional and find_spec(optional[1]) is None:
        pytest.skip(f"{optional[1]} is not installed (extra interop)")
    done = subprocess.run(
        [sys.executable, str(example), *ARGUMENTS.get(example.stem, [])],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "separation" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_there_is_a_native_and_an_fmu_example() -> None:
    assert {"native_run", "fmu_run"} <= {example.stem for example in EXAMPLES}

"""The README's commands run, and what it repeats from the code agrees with it."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from fivtui.core.parameters import PARAMETERS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```sh\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)
TASKS = [block.splitlines() for block in BLOCKS if block.startswith("fivtui")]


@pytest.mark.parametrize("task", TASKS, ids=[task[0] for task in TASKS])
def test_a_common_task_runs_as_written(task: list[str], tmp_path: Path) -> None:
    for line in task:
        words = shlex.split(line)
        assert words[0] == "fivtui"
        done = subprocess.run(
            [sys.executable, "-m", "fivtui", *words[1:]],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout or "wrote" in done.stderr


def test_the_python_lines_run() -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    growth_rate, run, table = done.stdout.splitlines()
    assert float(growth_rate) < 0.0
    assert run.split()[1] == "74"
    assert table.count("'done'") == 2


def test_the_lines_of_a_batch_run() -> None:
    (code,) = re.findall(r"^```py\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "10.5027" in done.stdout
    assert "[74 74 74]" in done.stdout


def test_the_table_of_parameters_is_that_of_the_code() -> None:
    for spec in PARAMETERS.values():
        row = f"| `{spec.name}` | {spec.unit or '–'} | {spec.default:g} | {spec.meaning} |"
        assert row in README

"""Shell completion by Tab: commands, options, presets, files and names after options."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest
from click.shell_completion import BashComplete

from fivtui.cli import commands
from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.scene.presets import PRESETS
from fivtui.transient import ALL_METHODS, QUANTITIES
from fivtui.transient.settings.checks import START_SPECS

ROOT = Path(__file__).parents[2]


def completion_environment(line: str) -> dict[str, str]:
    """The environment in which bash asks for the completion of the last word of a line."""
    return {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}


def plain_candidates(names: Iterable[str]) -> list[str]:
    return [f"plain,{name}" for name in names]


ASSIGNED = [f"{name}=" for name in ALL_PARAMETERS]
VARIED = [f"{name}=" for name in (*ALL_PARAMETERS, *START_SPECS)]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("fivtui ", plain_candidates(sorted(commands.commands))),
        ("fivtui sta", ["plain,stability"]),
        ("fivtui fmu b", ["plain,build"]),
        ("fivtui simulate ", plain_candidates(list(PRESETS))),
        ("fivtui simulate lin", ["plain,linear"]),
        ("fivtui simulate mine.to", ["file,mine.to"]),
        ("fivtui simulate --met", ["plain,--method"]),
        ("fivtui simulate --method ", plain_candidates(list(ALL_METHODS))),
        ("fivtui simulate --set ", plain_candidates(ASSIGNED)),
        (
            "fivtui stability --set F=120 --set k",
            plain_candidates([n for n in ASSIGNED if n[0] == "k"]),
        ),
        ("fivtui sweep --set c", ["plain,c1=", "plain,c2="]),
        ("fivtui simulate --error ", plain_candidates([f"{name}=" for name in QUANTITIES])),
        ("fivtui sweep --vary ", plain_candidates(VARIED)),
        ("fivtui map --over k_", ["plain,k_nl="]),
        ("fivtui attractors --vary m", ["plain,m=", "plain,mu="]),
        ("fivtui attractors --basin v", ["plain,vx0=", "plain,vy0="]),
        ("fivtui simulate --out r", ["file,r"]),
        ("fivtui fmu check s", ["file,s"]),
        ("fivtui figures --out f", ["dir,f"]),
        # A wrong line completes as usual; errors are reported when it runs.
        ("fivtui no-such-command ", plain_candidates(sorted(commands.commands))),
        ("fivtui simulate --tol 1 --tol 2 --set m", plain_candidates(["m=", "mu=", "mu_s="])),
        ("fivtui simulate --tol '' --set m", plain_candidates(["m=", "mu=", "mu_s="])),
        ("fivtui stability no-such-scene --set m", plain_candidates(["m=", "mu=", "mu_s="])),
    ],
)
def test_typed_prefixes_are_completed(
    line: str, expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in completion_environment(line).items():
        monkeypatch.setenv(name, value)
    shell = BashComplete(commands, {}, "fivtui", "_FIVTUI_COMPLETE")
    assert shell.complete().split() == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("fivtui stability --set k", plain_candidates([n for n in ASSIGNED if n[0] == "k"])),
        ("fivtui no-such-command --set k", []),
        ("fivtui simulate --tol 1 --tol 2 --method t", ["plain,taylor"]),
    ],
)
def test_completion_prints_only_the_candidates(line: str, expected: list[str]) -> None:
    process = subprocess.run(
        [sys.executable, "-m", "fivtui"],
        env=os.environ
        | completion_environment(line)
        | {"PYTHONPATH": str(ROOT), "_FIVTUI_COMPLETE": "bash_complete"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
    )
    assert (process.stdout.split(), process.stderr) == (expected, "")


@pytest.mark.host
@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not there")
def test_bash_completes_by_the_line_of_the_manual(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    line = 'eval "$(_FIVTUI_COMPLETE=bash_source fivtui)"'
    assert f"`{line}`" in page
    program = tmp_path / "fivtui"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m fivtui "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    script = f"""{line}
complete -p fivtui
COMP_WORDS=(fivtui stability --set k); COMP_CWORD=3
_fivtui_completion fivtui
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    process = subprocess.run(
        ["bash", "--norc", "-c", script],
        env=os.environ
        | {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    first, *values = process.stdout.split("\n")
    assert first.startswith("complete ")
    assert values == [*(name for name in ASSIGNED if name[0] == "k"), ""]

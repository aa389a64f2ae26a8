"""Blocks of README and manual run, and statements in README agree with the code.

Blocks are those of plain `sh` and `python`. The directive `run` of the manual has further commands,
which are run when the manual is built.
"""

import re
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest

from fivtui.tradeoffs import measure
from tests.support.processes import run_python
from tests.support.readme_commands import (
    hide_extras,
    reduced,
    run_blocks,
    shorten_comparisons,
    shorten_searches,
)

ROOT = Path(__file__).parents[1]
# A block that is run: its language and text.
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
README = (ROOT / "README.md").read_text(encoding="utf-8")
DOCUMENTS = {
    "README.md": README,
    **{
        str(path.relative_to(ROOT)): text
        for path in sorted(ROOT.glob("docs/**/*.md"))
        if BLOCK.search(text := path.read_text(encoding="utf-8"))
    },
}


def blocks_in(text: str) -> list[tuple[str, str]]:
    """Language and text of the blocks to run."""
    return BLOCK.findall(text)


BLOCKS = {name: blocks_in(text) for name, text in DOCUMENTS.items()}
# Outputs that the README shows below its blocks.
SHOWN = re.findall(r"^```text\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def shown_lines() -> list[str]:
    """Lines that the README shows of the outputs of its blocks."""
    return [line for text in SHOWN for line in text.splitlines() if line != "…"]


def check_blocks(
    blocks: list[tuple[str, str]], change: Callable[[list[str]], list[str]] = list
) -> str:
    """Run blocks in order in this folder, commands after `change`; return what they print."""
    printed = run_blocks(blocks, change)
    wrong = [f"{command.line}: {command.error}" for command in printed if command.code]
    assert not wrong, "\n".join(wrong)
    # A command that writes a file prints on stderr alone: "wrote …".
    assert all(command.out or "wrote" in command.error for command in printed)
    commands = re.findall(r"^fivtui ", "".join(text for _, text in blocks), flags=re.MULTILINE)
    scripts = [text for language, text in blocks if language == "python"]
    assert len(printed) >= len(commands) + len(scripts)
    return "".join(command.out for command in printed)


@pytest.mark.slow
@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_blocks_run_in_order_in_one_folder_without_packages_of_extras(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hide_extras(monkeypatch)
    shorten_comparisons(monkeypatch)
    if name == "docs/how-to/belt-speed.md":
        # On belts of finite speed interpreted code follows cycles, which is slow.
        shorten_searches(monkeypatch)
    out = check_blocks(BLOCKS[name], list if name == "README.md" else reduced)
    if name == "README.md":
        # A search in an iterator goes on after the line before, so the order must be the same.
        printed = iter(out.splitlines())
        assert not [line for line in shown_lines() if line not in printed]


@pytest.mark.whole
@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_blocks_run_with_all_their_points(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hide_extras(monkeypatch)
    # CPU time of a trade-off, s.
    monkeypatch.setattr(measure, "QUICK_S", 1.0)
    check_blocks(BLOCKS[name])


def test_reduced_commands_differ_in_counts_alone() -> None:
    line = "map --over F=20:150:27 --over k_nl=5:50:4:log --vary mu~uniform:0.2:0.8 --samples 1024"
    assert " ".join(reduced(line.split())) == (
        "map --over F=20:150:2 --over k_nl=5:50:2:log --vary mu~uniform:0.2:0.8 --samples 16"
    )
    assert reduced(["branch", "--vary", "mu=0.2:1"]) == ["branch", "--vary", "mu=0.2:1"]


def test_every_block_of_the_readme_is_run() -> None:
    fences = re.findall(r"^```(\w+)$", README, flags=re.MULTILINE)
    assert len(BLOCKS["README.md"]) + fences.count("text") == len(fences)
    assert len(SHOWN) == fences.count("text") == 5
    assert len(README.splitlines()) <= 120


def test_the_source_distribution_has_every_file_named_in_the_readme(tmp_path: Path) -> None:
    run_python("-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path)
    (archive,) = tmp_path.iterdir()
    with tarfile.open(archive) as file:
        archived = {name.partition("/")[2] for name in file.getnames()}
    links = set(re.findall(r"\]\((?!http)([^)#]+)\)", README))
    commands = " ".join(text for language, text in BLOCKS["README.md"] if language == "sh")
    files = {"pyproject.toml", *re.findall(r"[\w./-]+\.txt", commands)}
    assert ".ci/constraints.txt" in files
    for name in links | files:
        assert any(entry == name or entry.startswith(f"{name}/") for entry in archived), name

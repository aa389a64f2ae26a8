"""Blocks of README and manual run, and statements in README agree with the code.

The build of the manual runs its other commands, those of the directive `run`.
"""

import re
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest

from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.tradeoffs import measure
from tests.support.processes import run_python
from tests.support.readme_commands import (
    hide_extras,
    reduced,
    run_blocks,
    shorten,
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
# First lines of the parts of long documents; the parts take about equal time.
PARTS = {
    "README.md": [
        "python3 -m venv",
        "fivtui stability --set F=120 --attractors",
        "fivtui accuracy",
        "fivtui presets",
    ],
}


def blocks_of(name: str, first: str) -> list[tuple[str, str]]:
    """Blocks of a document from the one that starts with `first` up to the next part."""
    blocks, parts = BLOCKS[name], PARTS.get(name, [""])
    begins = [
        next(index for index, (_, text) in enumerate(blocks) if text.startswith(begin))
        for begin in parts
    ]
    assert begins == sorted(set(begins))
    index = parts.index(first)
    return blocks[begins[index] : [*begins, len(blocks)][index + 1]]


ALL_PARTS = [(name, first) for name in DOCUMENTS for first in PARTS.get(name, [""])]


def check_blocks(
    blocks: list[tuple[str, str]], change: Callable[[list[str]], list[str]] = list
) -> dict[str, str]:
    """Run blocks in order in this folder; return outputs by command line, scripts by language."""
    printed = run_blocks(blocks, change)
    wrong = [f"{command.line}: {command.error}" for command in printed if command.code]
    assert not wrong, "\n".join(wrong)
    assert all(command.out or "wrote" in command.error for command in printed)
    lines = [text.count("\nfivtui ") + text.startswith("fivtui ") for _, text in blocks]
    assert len(printed) >= sum(lines) + sum(language != "sh" for language, _ in blocks)
    return {command.line: command.out for command in printed}


def check_scripts(name: str, by_line: dict[str, str]) -> None:
    if name == "README.md" and "python" in by_line:
        growth_rate, run, table = by_line["python"].splitlines()
        assert float(growth_rate) < 0.0
        assert run.split()[1] == "74"
        assert table.count("'done'") == 2
    if name == "docs/how-to/sweep.md":
        assert "10.5027" in by_line["python"]
        assert "[74 74 74]" in by_line["python"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "first"), ALL_PARTS)
def test_the_blocks_run_in_order_in_one_folder_as_installed_there(
    name: str, first: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hide_extras(monkeypatch)
    shorten(monkeypatch)
    if name == "docs/how-to/belt-speed.md":
        # On belts of finite speed interpreted code follows cycles, which is slow.
        shorten_searches(monkeypatch)
    check_scripts(name, check_blocks(blocks_of(name, first), reduced))


@pytest.mark.whole
@pytest.mark.parametrize(("name", "first"), ALL_PARTS)
def test_the_blocks_run_with_all_their_points(
    name: str, first: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hide_extras(monkeypatch)
    monkeypatch.setattr(measure, "QUICK_S", 1.0)
    check_scripts(name, check_blocks(blocks_of(name, first)))


def test_reduced_commands_differ_in_counts_alone() -> None:
    line = "map --over F=20:150:27 --over k_nl=5:50:4:log --vary mu~uniform:0.2:0.8 --samples 1024"
    assert " ".join(reduced(line.split())) == (
        "map --over F=20:150:2 --over k_nl=5:50:2:log --vary mu~uniform:0.2:0.8 --samples 64"
    )
    assert reduced(["branch", "--vary", "mu=0.2:1"]) == ["branch", "--vary", "mu=0.2:1"]


def test_the_parts_cover_all_blocks_and_share_no_output_file() -> None:
    parts = [blocks_of(name, first) for name, first in ALL_PARTS]
    blocks = [block for blocks in parts for block in blocks]
    assert blocks == [block for blocks in BLOCKS.values() for block in blocks]
    assert all(BLOCKS.values())
    assert {language for language, _ in blocks} == {"sh", "python"}
    written = [
        name
        for blocks in parts
        for name in {
            name for _, text in blocks for name in re.findall(r"--(?:out|plot|events) (\S+)", text)
        }
    ]
    assert len(written) > 15
    assert len(written) == len(set(written))


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


def test_the_table_of_parameters_is_that_of_the_code() -> None:
    for spec in ALL_PARAMETERS.values():
        default = "none" if spec.optional else f"{spec.default:g}"
        row = f"| `{spec.name}` | {spec.unit or '–'} | {default} | {spec.meaning} |"
        assert row in README

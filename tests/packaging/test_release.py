"""The release: one version everywhere, its date, and the programs of the hooks before commits."""

import re
import tomllib
from pathlib import Path

from fivtui import __version__
from fivtui.cli import run

ROOT = Path(__file__).parents[2]


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_changelog_and_citation_name_the_version_and_its_date() -> None:
    released = re.findall(
        r"^## (\d\S*) - (\d{4}-\d\d-\d\d)$", text_of("CHANGELOG.md"), re.MULTILINE
    )
    version, date = released[0]
    assert version == __version__
    citation = text_of("CITATION.cff")
    assert f"\nversion: {version}\n" in citation
    assert f"\ndate-released: {date}\n" in citation
    # The version and its date identify the release; it has no DOI.
    assert "doi" not in citation


def test_the_command_line_names_the_version(capsys) -> None:  # type: ignore[no-untyped-def]
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"fivtui {__version__}\n"


def test_the_hooks_before_commits_are_the_programs_of_the_extra_dev() -> None:
    entries = re.findall(r"^ +entry: (\S+)", text_of(".pre-commit-config.yaml"), re.MULTILINE)
    extras = tomllib.loads(text_of("pyproject.toml"))["project"]["optional-dependencies"]
    # The extra dev includes the extra test. Its package import-linter has the program lint-imports.
    packages = " ".join([*extras["dev"], *extras["test"]]).replace("import-linter", "lint-imports")
    assert len(entries) == 4
    assert all(re.search(rf"(^| ){entry}\b", packages) for entry in entries)
    assert all(entry in text_of(".ci/run") for entry in entries)

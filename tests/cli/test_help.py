"""The help: commands by purpose, grouped options, examples that run, pages of the manual."""

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from fivtui.cli import commands, manual, run
from fivtui.cli.manual import ENTRIES, SECTIONS
from fivtui.sweeps.study import OUTPUTS
from tests.support.readme_commands import reduced

ROOT = Path(__file__).parents[2]
# Examples that take more than a few seconds, also with reduced counts.
LONG = ("compare", "animate", "uncertainty", "tradeoff", "extremes", "figures", "claims")
# Examples that end only when the user stops them, or need an installed manual.
NOT_RUN = ("tui", "serve", "docs")


def all_commands(group: click.Group, prefix: str = "") -> Iterator[tuple[str, click.Command]]:
    for name, command in group.commands.items():
        yield prefix + name, command
        if isinstance(command, click.Group):
            yield from all_commands(command, f"{prefix}{name} ")


COMMANDS = dict(all_commands(commands))


def printed(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    assert run(args) == 0
    out, error = capsys.readouterr()
    assert error == ""
    return out


def test_every_command_stands_in_one_section_with_its_whole_summary(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = printed(capsys, "--help")
    titles = re.findall(r"^(\w.*):$", text, flags=re.MULTILINE)
    assert titles == [*SECTIONS, "Options"]
    for name, command in COMMANDS.items():
        summary = re.sub(r"\s+", " ", str(command.help).split("\n\n")[0])
        (line,) = (line for line in text.splitlines() if re.match(rf"  {name}   *\w.*\.$", line))
        assert line.split(maxsplit=len(name.split()))[-1].strip() == summary
        assert len(line) <= 80


def test_a_group_of_commands_without_a_command_prints_its_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert printed(capsys, "fmu") == printed(capsys, "fmu", "-h")


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_each_help_has_an_example_and_names_its_page(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(capsys, *name.split(), "--help")
    assert text == printed(capsys, *name.split(), "-h")
    (example,) = re.findall(r"^  Example:\n    fivtui (.+)\n\n", text, flags=re.MULTILINE)
    assert name in example
    page, opener = re.findall(r"  Manual:\n    (\S+)\.html, opened by (.+)\n", text)[0]
    page_argument = [] if page == "index" else [page.rpartition("/")[2]]
    assert shlex.split(opener) == ["fivtui", "docs", *page_argument]
    assert all(len(line) <= 80 for line in text.splitlines())


def test_the_options_of_long_commands_are_grouped(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "sweep", "-h")
    titles = re.findall(r"^(\w.*):$", text, flags=re.MULTILINE)
    assert titles == ["Study", "Scene", "Method and accuracy", "Computation", "Output"]
    options = [p.opts[0] for p in COMMANDS["sweep"].params if isinstance(p, click.Option)]
    assert all(re.search(rf"^  {option} ", text, flags=re.MULTILINE) for option in options)
    # The texts after options and their values begin in one column.
    text_columns = {len(match) for match in re.findall(r"(?m)^  --[\w-]+ [A-Z=]+  +", text)}
    assert len(text_columns) == 1
    assert "\nOptions:\n" in printed(capsys, "accuracy", "-h")


def test_each_page_is_in_the_manual() -> None:
    absent = {
        entry.page for entry in ENTRIES.values() if not (ROOT / f"docs/{entry.page}.md").is_file()
    }
    assert not absent


@pytest.mark.parametrize("name", ENTRIES)
def test_each_example_is_a_valid_command_line(name: str) -> None:
    arguments = shlex.split(ENTRIES[name].example)
    length = 2 if arguments[0] == "fmu" else 1
    command = COMMANDS[" ".join(arguments[:length])]
    # Raises an error if the arguments are not valid.
    command.make_context(None, arguments[length:])


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        [name for name in ENTRIES if name not in (*LONG, *NOT_RUN)],
        *(pytest.param([name], marks=pytest.mark.whole) for name in LONG),
    ],
    ids=lambda names: names[0],
)
def test_the_examples_run_in_order_in_one_folder(
    names: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if "validate" in names:
        assert run(["simulate", "--out", "measured.csv"]) == 0
    for name in names:
        assert run(reduced(shlex.split(ENTRIES[name].example))) == 0, name


@pytest.mark.parametrize(
    ("args", "hint"),
    [
        ("simulate F=80", "F=80: parameters are set by --set, here --set F=80"),
        ("simulate base mu=0.5 --json", "--set mu=0.5"),
        ("simulate --mu 0.5", "--mu: parameters are set by --set, here --set mu=0.5"),
        ("stability --k_nl=5", "--k_nl=5: parameters are set by --set, here --set k_nl=5"),
        ("stability -F -5", "--set F=-5"),
        ("sweep -mu .5", "--set mu=.5"),
        ("map --F --json", "--set F=VALUE"),
        ("fmu run absent.fmu --F=3", "--set F=3"),
    ],
)
def test_a_parameter_given_without_set_is_answered_with_set(
    args: str, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(args.split()) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert error.rstrip().endswith(hint)
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ("simulate base --set F=80 --nothing", "No such option '--nothing'"),
        ("simulate --tol= --set F=80", "--tol: must not be empty"),
        ("presets --mu 0.5", "No such option '--mu'"),
        ("simulate base other", "unexpected extra argument"),
    ],
)
def test_other_wrong_arguments_are_reported_as_such(
    args: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(args.split()) == 2
    assert message in capsys.readouterr().err


def test_the_help_of_sweep_names_every_output_with_its_unit(
    capsys: pytest.CaptureFixture[str],
) -> None:
    # The help lists names by unit: "In m: y_abs (peak), y_max, …; in m/s: vx_max, …; numbers: …".
    text = re.sub(r"\s+", " ", printed(capsys, "sweep", "--help"))
    (listed,) = re.findall(r"may be repeated\. (In m: .*?)\. Scene:", text)
    units = {"In m": "m", "in m/s": "m/s", "in N": "N", "in s": "s", "in 1/s": "1/s"}
    without_remarks = re.sub(r" \(.*?\)", "", listed)
    groups = [group.split(": ") for group in without_remarks.split("; ")]
    listed_units = {
        name: units.get(title, "") for title, names in groups for name in names.split(", ")
    }
    assert listed_units == {name: column.unit for name, column in OUTPUTS.items()}


def test_docs_without_a_manual_say_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(manual, "FOLDERS", (tmp_path,))
    assert run(["docs"]) == 2
    assert "there is no manual in this installation, nor in the folder" in capsys.readouterr().err


def test_docs_find_the_manual_in_the_folder_where_the_readme_builds_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "manual" / "index.html"
    page.parent.mkdir()
    page.touch()
    monkeypatch.setattr(manual, "FOLDERS", (tmp_path / "none", *manual.FOLDERS[1:]))
    assert manual.find_page(None) == page.resolve()


@pytest.fixture
def installed_manual(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("index", "how-to/index", "how-to/trust", "how-to/sweep"):
        file = tmp_path / f"{name}.html"
        file.parent.mkdir(exist_ok=True)
        file.touch()
    monkeypatch.setattr(manual, "FOLDERS", (tmp_path,))
    return tmp_path


@pytest.mark.parametrize(
    ("args", "page"),
    [
        ([], "index"),
        (["trust"], "how-to/trust"),
        (["how-to/trust"], "how-to/trust"),
        (["trust.html"], "how-to/trust"),
        (["accuracy"], "how-to/trust"),
        (["sweep"], "how-to/sweep"),
    ],
)
def test_docs_open_a_page_in_the_browser_and_print_its_address(
    args: list[str],
    page: str,
    installed_manual: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    address = (installed_manual / f"{page}.html").as_uri()
    assert run(["docs", *args]) == 0
    assert capsys.readouterr().out == f"{address}\n"
    assert opened == [address]


@pytest.mark.usefixtures("installed_manual")
def test_docs_suggest_the_nearest_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["docs", "trsut"]) == 2
    assert "unknown page 'trsut'; did you mean trust?" in capsys.readouterr().err


def test_docs_without_a_browser_print_the_address(tmp_path: Path) -> None:
    (tmp_path / "index.html").touch()
    code = (
        "from pathlib import Path\n"
        "from fivtui.cli import manual, run\n"
        f"manual.FOLDERS = (Path({str(tmp_path)!r}),)\n"
        "raise SystemExit(run(['docs']))\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code],
        env={"PATH": "", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stdout == f"{(tmp_path / 'index.html').as_uri()}\n"
    assert "no browser" in process.stderr

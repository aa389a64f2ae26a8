"""Output paths: never an input, never the same file twice, never a partial file."""

import os
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from fivtui.cli import commands, run
from fivtui.cli.group import CheckedCommand
from fivtui.cli.paths import InputFile, OutputFile, OutputFolder, SceneName
from fivtui.io import files, output_path
from fivtui.io.files import check_distinct, parts_folder
from fivtui.io.writing import write_atomically
from fivtui.model.errors import InputError
from fivtui.paper.export import figure_files, save_figures
from fivtui.scene.comparison import compare, comparison_files
from fivtui.scene.presets import PRESETS

SCENE = 'fivtui_scene = 1\noutputs = ["transient", "trajectory"]\n'


@pytest.fixture(autouse=True)
def _in_a_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def list_commands(group: click.Group, above: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from list_commands(command, (*above, name))
        else:
            yield (*above, name)


def find_command(names: tuple[str, ...]) -> click.Command:
    command: click.Command = commands
    for name in names:
        assert isinstance(command, click.Group)
        command = command.commands[name]
    return command


ALL_COMMANDS = list(list_commands(commands))
# The commands that write files, with the arguments that each needs besides its output paths.
REQUIRED_ARGUMENTS: dict[tuple[str, ...], list[str]] = {
    ("stability",): [],
    ("attractors",): ["--vary=F=20:80:2"],
    ("branch",): ["--vary=mu=0.3:0.5"],
    ("map",): ["--over=F=20:80:2", "--over=mu=0.1:1:2"],
    ("simulate",): [],
    ("run",): [],
    ("sweep",): ["--vary=F=20:80:2"],
    ("tradeoff",): [],
    ("uncertainty",): ["--vary=mu~uniform:0:1", "--samples=64", "--output=critical_mu"],
    ("animate",): [],
    ("sound",): [],
    # Any existing file: paths are checked before measured data are read.
    ("validate",): [f"--measured={__file__}"],
    ("identify",): [f"--measured={__file__}", "--fit=mu"],
    ("fmu", "build"): [],
    ("fmu", "system"): [],
    ("fmu", "run"): [],
}
SUFFIXES: dict[tuple[str, ...], str] = {
    ("fmu", "build"): ".fmu",
    ("fmu", "system"): ".ssp",
    ("animate",): ".gif",
    ("sound",): ".wav",
    ("identify",): ".toml",
}


def output_flags(names: tuple[str, ...]) -> list[str]:
    params = find_command(names).params
    return [param.opts[0] for param in params if isinstance(param.type, OutputFile)]


def input_params(names: tuple[str, ...]) -> list[click.Parameter]:
    params = find_command(names).params
    return [param for param in params if isinstance(param.type, (InputFile, SceneName))]


def test_every_command_declares_its_input_and_output_paths() -> None:
    for names in ALL_COMMANDS:
        command = find_command(names)
        # A `CheckedCommand` refuses to write an output to another output or an input.
        assert isinstance(command, CheckedCommand)
        for param in command.params:
            kinds = (InputFile, OutputFile, OutputFolder)
            assert not isinstance(param.type, click.Path) or isinstance(param.type, kinds)
            assert isinstance(param.type, SceneName) == (param.name == "scene")
    commands_with_outputs = {names for names in ALL_COMMANDS if output_flags(names)}
    assert commands_with_outputs == set(REQUIRED_ARGUMENTS)
    folders = {
        n
        for n in ALL_COMMANDS
        if any(isinstance(p.type, OutputFolder) for p in find_command(n).params)
    }
    assert folders == {("figures",), ("compare",)}


def build_arguments(names: tuple[str, ...], paths: dict[str, str], argument: str = "") -> list[str]:
    # `paths` are files by option, `argument` is the scene or the FMU to be read.
    if names == ("fmu", "run"):
        argument = argument or "some.fmu"
    options = [f"{name}={path}" for name, path in paths.items()]
    # A path may be that of a required option, such as --measured.
    required = [
        option for option in REQUIRED_ARGUMENTS[names] if option.partition("=")[0] not in paths
    ]
    return [*names, *([argument] if argument else []), *required, *options, "--force"]


def read_texts(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def file_names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def run_refused(args: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert run(args) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def link(path: str, target: str, alias: str) -> None:
    if alias == "hard":
        os.link(target, path)
    else:
        Path(path).symlink_to(target)


@pytest.mark.parametrize(
    "names", [n for n in REQUIRED_ARGUMENTS if len(output_flags(n)) > 1], ids=" ".join
)
@pytest.mark.parametrize("alias", ["same", "dotted", "hard", "soft", "dangling"])
def test_two_outputs_to_one_file_are_refused(
    names: tuple[str, ...], alias: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    first, second = output_flags(names)
    paths = {"same": "a.csv", "dotted": "x/../a.csv", "hard": "h.csv", "soft": "s.csv"}
    Path("a.csv").write_text("mine")
    Path("x").mkdir()
    if alias in ("hard", "soft"):
        link(paths[alias], "a.csv", alias)
    if alias == "dangling":
        link("d.csv", "new.csv", "soft")
        outputs = {first: "d.csv", second: "new.csv"}
    else:
        outputs = {first: "a.csv", second: paths[alias]}
    before = read_texts(tmp_path)
    message = run_refused(build_arguments(names, outputs), capsys)
    assert "is the same file as" in message
    assert first in message
    assert second in message
    assert read_texts(tmp_path) == before


@pytest.mark.parametrize("names", [n for n in REQUIRED_ARGUMENTS if input_params(n)], ids=" ".join)
@pytest.mark.parametrize("alias", ["same", "hard", "soft"])
def test_an_output_that_is_an_input_is_refused(
    names: tuple[str, ...], alias: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for flag in output_flags(names):
        for param in input_params(names):
            Path("in.csv").write_text(SCENE)
            out = "in.csv" if alias == "same" else f"out{flag}.csv"
            if alias != "same":
                Path(out).unlink(missing_ok=True)
                link(out, "in.csv", alias)
            if isinstance(param, click.Argument):
                args = build_arguments(names, {flag: out}, "in.csv")
            else:
                args = build_arguments(names, {flag: out, param.opts[0]: "in.csv"})
            message = run_refused(args, capsys)
            assert "is the same file as" in message
            assert "which is read" in message
            assert Path("in.csv").read_text() == SCENE
            assert Path(out).read_text() == SCENE


@pytest.mark.parametrize("parameter", ["--plot", "scene"])
def test_files_in_the_folder_of_a_sweeps_pieces_are_refused(
    parameter: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    parts = parts_folder(Path("out.csv"))
    parts.mkdir()
    (parts / "a.png").write_text(SCENE)
    path = "out.csv.parts/a.png"
    options = [f"--plot={path}", "--force"] if parameter == "--plot" else [path]
    message = run_refused(["sweep", *options, "--vary=F=20:80:2", "--out=out.csv"], capsys)
    assert "is in the folder" in message
    assert read_texts(parts) == {"a.png": SCENE}
    assert not Path("out.csv").exists()


@pytest.mark.parametrize("names", REQUIRED_ARGUMENTS, ids=" ".join)
def test_an_unwritable_output_is_a_one_line_error_before_any_work(
    names: tuple[str, ...], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    Path("file").write_text("mine")
    Path("scene.toml").write_text(SCENE)
    scene = "scene.toml" if names == ("run",) else ""
    for flag in output_flags(names):
        kind = ".png" if flag == "--plot" else SUFFIXES.get(names, ".csv")
        if not Path(f"folder{kind}").exists():
            Path(f"folder{kind}").mkdir()
            # A link to itself, and two links to each other.
            link(f"loop{kind}", f"loop{kind}", "soft")
            link(f"first{kind}", f"second{kind}", "soft")
            link(f"second{kind}", f"first{kind}", "soft")
        for path, reason in (
            (f"folder{kind}", "is a folder"),
            (f"loop{kind}", "leads back to itself"),
            (f"first{kind}", "leads back to itself"),
            (f"missing/a{kind}", "there is no folder"),
            (f"file/a{kind}", "there is no folder"),
            (f"loop{kind}/a{kind}", "there is no folder"),
            (f"{'n' * 300}{kind}", "File name too long"),
        ):
            before = file_names(tmp_path)
            assert reason in run_refused(build_arguments(names, {flag: path}, scene), capsys)
            assert file_names(tmp_path) == before
            assert Path("file").read_text() == "mine"
            assert Path(f"loop{kind}").is_symlink()


def test_a_dangling_link_creates_its_target_and_stays(tmp_path: Path) -> None:
    Path("data").mkdir()
    link("out.csv", "data/new.csv", "soft")
    link("chain.csv", "out.csv", "soft")
    assert run(["simulate", "--t-end=1", "--out=chain.csv", "--points=2"]) == 0
    assert Path("out.csv").is_symlink()
    assert Path("chain.csv").is_symlink()
    assert Path("data/new.csv").read_text().count("\n") > 2
    assert file_names(tmp_path / "data") == ["new.csv"]


def test_picture_and_data_of_a_figure_in_one_file_are_refused(tmp_path: Path) -> None:
    figure = figure_files(2, tmp_path, ["svg", "png"])
    figure.pictures[0].symlink_to(figure.data[0])
    with pytest.raises(InputError, match="is the same file as"):
        save_figures([2], output_path(tmp_path, force=True), formats=["svg", "png"])
    assert [path.name for path in tmp_path.iterdir()] == [figure.pictures[0].name]


def test_fmu_and_picture_of_a_comparison_in_one_file_are_refused(tmp_path: Path) -> None:
    # `compare` runs a scene natively and by an FMU, and writes the FMU and a figure of the runs.
    fmu, figure = comparison_files(tmp_path)
    figure.symlink_to(fmu)
    with pytest.raises(InputError, match="is the same file as"):
        compare(PRESETS["base"], output_path(tmp_path, force=True))
    assert file_names(tmp_path) == [figure.name]


def test_a_comparison_does_not_overwrite_its_scene(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for index in range(2):
        path = comparison_files(Path("out"))[index]
        path.parent.mkdir(exist_ok=True)
        path.write_text(SCENE)
        message = run_refused(["compare", str(path), "--out=out", "--force"], capsys)
        assert "which is read" in message
        assert path.read_text() == SCENE


@pytest.mark.parametrize("ignores_case", [True, False])
def test_paths_that_differ_in_case_are_one_file_only_in_a_folder_that_ignores_case(
    ignores_case: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    outputs = [("--out", tmp_path / "A.csv"), ("--events", tmp_path / "a.CSV")]
    (tmp_path / "probe").touch()
    if (tmp_path / "PROBE").exists():
        pytest.skip("this folder takes capital letters for small ones")
    check_distinct(outputs)
    monkeypatch.setattr(files, "_ignores_case", lambda folder: folder == tmp_path and ignores_case)
    if ignores_case:
        with pytest.raises(InputError, match="is the same file as"):
            check_distinct(outputs)
    else:
        check_distinct(outputs)
    assert [path.name for path in tmp_path.iterdir()] == ["probe"]


def test_a_link_to_itself_is_refused_and_stays(tmp_path: Path) -> None:
    link("loop.csv", "loop.csv", "soft")
    with pytest.raises(InputError, match=r"loop\.csv: is a symbolic link that leads back to"):
        write_atomically(output_path("loop.csv", force=True), lambda file: None)
    assert file_names(tmp_path) == ["loop.csv"]
    assert Path("loop.csv").is_symlink()

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


def commands_in(group: click.Group, above: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands_in(command, (*above, name))
        else:
            yield (*above, name)


def command_of(names: tuple[str, ...]) -> click.Command:
    command: click.Command = commands
    for name in names:
        assert isinstance(command, click.Group)
        command = command.commands[name]
    return command


ALL = list(commands_in(commands))
# Arguments that each command needs besides its output paths.
NEEDED: dict[tuple[str, ...], list[str]] = {
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
    ("validate",): [f"--measured={__file__}"],
    ("fmu", "build"): [],
    ("fmu", "system"): [],
    ("fmu", "run"): [],
}
SUFFIXES: dict[tuple[str, ...], str] = {
    ("fmu", "build"): ".fmu",
    ("fmu", "system"): ".ssp",
    ("animate",): ".gif",
    ("sound",): ".wav",
}


def outputs_of(names: tuple[str, ...]) -> list[str]:
    params = command_of(names).params
    return [param.opts[0] for param in params if isinstance(param.type, OutputFile)]


def inputs_of(names: tuple[str, ...]) -> list[click.Parameter]:
    params = command_of(names).params
    return [param for param in params if isinstance(param.type, (InputFile, SceneName))]


def test_every_command_declares_its_input_and_output_paths() -> None:
    for names in ALL:
        command = command_of(names)
        assert isinstance(command, CheckedCommand)
        for param in command.params:
            kinds = (InputFile, OutputFile, OutputFolder)
            assert not isinstance(param.type, click.Path) or isinstance(param.type, kinds)
            assert (param.name == "scene") == isinstance(param.type, SceneName)
    assert {names for names in ALL if outputs_of(names)} == set(NEEDED)
    folders = {
        n for n in ALL if any(isinstance(p.type, OutputFolder) for p in command_of(n).params)
    }
    assert folders == {("figures",), ("compare",)}


def arguments(names: tuple[str, ...], outputs: dict[str, str], argument: str = "") -> list[str]:
    if names == ("fmu", "run"):
        argument = argument or "some.fmu"
    options = [f"{name}={path}" for name, path in outputs.items()]
    needed = [option for option in NEEDED[names] if option.partition("=")[0] not in outputs]
    return [*names, *([argument] if argument else []), *needed, *options, "--force"]


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def refused(args: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert run(args) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def link(path: str, target: str, how: str) -> None:
    if how == "hard":
        os.link(target, path)
    else:
        Path(path).symlink_to(target)


@pytest.mark.parametrize("names", [n for n in NEEDED if len(outputs_of(n)) > 1], ids=" ".join)
@pytest.mark.parametrize("how", ["same", "dotted", "hard", "soft", "dangling"])
def test_two_outputs_are_two_files(
    names: tuple[str, ...], how: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    first, second = outputs_of(names)
    paths = {"same": "a.csv", "dotted": "x/../a.csv", "hard": "h.csv", "soft": "s.csv"}
    Path("a.csv").write_text("mine")
    Path("x").mkdir()
    if how in ("hard", "soft"):
        link(paths[how], "a.csv", how)
    if how == "dangling":
        link("d.csv", "new.csv", "soft")
        outputs = {first: "d.csv", second: "new.csv"}
    else:
        outputs = {first: "a.csv", second: paths[how]}
    before = contents(tmp_path)
    message = refused(arguments(names, outputs), capsys)
    assert "is the same file as" in message
    assert first in message
    assert second in message
    assert contents(tmp_path) == before


@pytest.mark.parametrize("names", [n for n in NEEDED if inputs_of(n)], ids=" ".join)
@pytest.mark.parametrize("how", ["same", "hard", "soft"])
def test_no_output_is_an_input(
    names: tuple[str, ...], how: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for flag in outputs_of(names):
        for param in inputs_of(names):
            Path("in.csv").write_text(SCENE)
            out = "in.csv" if how == "same" else f"out{flag}.csv"
            if how != "same":
                Path(out).unlink(missing_ok=True)
                link(out, "in.csv", how)
            if isinstance(param, click.Argument):
                args = arguments(names, {flag: out}, "in.csv")
            else:
                args = arguments(names, {flag: out, param.opts[0]: "in.csv"})
            message = refused(args, capsys)
            assert "is the same file as" in message
            assert "which is read" in message
            assert Path("in.csv").read_text() == SCENE
            assert Path(out).read_text() == SCENE


@pytest.mark.parametrize("flag", ["--plot", "scene"])
def test_a_sweep_has_the_folder_of_its_pieces_to_itself(
    flag: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    parts = parts_folder(Path("out.csv"))
    parts.mkdir()
    (parts / "a.png").write_text(SCENE)
    path = "out.csv.parts/a.png"
    options = [f"--plot={path}", "--force"] if flag == "--plot" else [path]
    message = refused(["sweep", *options, "--vary=F=20:80:2", "--out=out.csv"], capsys)
    assert "is in the folder" in message
    assert contents(parts) == {"a.png": SCENE}
    assert not Path("out.csv").exists()


@pytest.mark.parametrize("names", NEEDED, ids=" ".join)
def test_an_unwritable_output_is_a_one_line_error_before_any_work(
    names: tuple[str, ...], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    Path("file").write_text("mine")
    Path("scene.toml").write_text(SCENE)
    scene = "scene.toml" if names == ("run",) else ""
    for flag in outputs_of(names):
        kind = ".png" if flag == "--plot" else SUFFIXES.get(names, ".csv")
        if not Path(f"d{kind}").exists():
            Path(f"d{kind}").mkdir()
            link(f"loop{kind}", f"loop{kind}", "soft")
            link(f"b{kind}", f"c{kind}", "soft")
            link(f"c{kind}", f"b{kind}", "soft")
        for path, reason in (
            (f"d{kind}", "is a folder"),
            (f"loop{kind}", "leads back to itself"),
            (f"b{kind}", "leads back to itself"),
            (f"none/a{kind}", "there is no folder"),
            (f"file/a{kind}", "there is no folder"),
            (f"loop{kind}/a{kind}", "there is no folder"),
            (f"{'n' * 300}{kind}", "File name too long"),
        ):
            before = names_in(tmp_path)
            assert reason in refused(arguments(names, {flag: path}, scene), capsys)
            assert names_in(tmp_path) == before
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
    assert names_in(tmp_path / "data") == ["new.csv"]


def test_pictures_and_data_of_the_paper_are_different_files(tmp_path: Path) -> None:
    files_of = figure_files(2, tmp_path, ["svg", "png"])
    files_of.pictures[0].symlink_to(files_of.data[0])
    with pytest.raises(InputError, match="is the same file as"):
        save_figures([2], output_path(tmp_path, force=True), formats=["svg", "png"])
    assert [path.name for path in tmp_path.iterdir()] == [files_of.pictures[0].name]


def test_the_files_of_a_comparison_are_different_ones(tmp_path: Path) -> None:
    fmu, figure = comparison_files(tmp_path)
    figure.symlink_to(fmu)
    with pytest.raises(InputError, match="is the same file as"):
        compare(PRESETS["base"], output_path(tmp_path, force=True))
    assert names_in(tmp_path) == [figure.name]


def test_a_comparison_does_not_overwrite_its_scene(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for index in range(2):
        path = comparison_files(Path("out"))[index]
        path.parent.mkdir(exist_ok=True)
        path.write_text(SCENE)
        message = refused(["compare", str(path), "--out=out", "--force"], capsys)
        assert "which is read" in message
        assert path.read_text() == SCENE


@pytest.mark.parametrize("ignored", [True, False])
def test_upper_case_names_another_file_in_a_case_sensitive_folder(
    ignored: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    outputs = [("--out", tmp_path / "A.csv"), ("--events", tmp_path / "a.CSV")]
    (tmp_path / "probe").touch()
    if (tmp_path / "PROBE").exists():
        pytest.skip("this folder takes capital letters for small ones")
    check_distinct(outputs)
    monkeypatch.setattr(files, "_ignores_case", lambda folder: folder == tmp_path and ignored)
    if ignored:
        with pytest.raises(InputError, match="is the same file as"):
            check_distinct(outputs)
    else:
        check_distinct(outputs)
    assert [path.name for path in tmp_path.iterdir()] == ["probe"]


def test_a_link_to_itself_is_refused_and_stays(tmp_path: Path) -> None:
    link("loop.csv", "loop.csv", "soft")
    with pytest.raises(InputError, match=r"loop\.csv: is a symbolic link that leads back to"):
        write_atomically(output_path("loop.csv", force=True), lambda file: None)
    assert names_in(tmp_path) == ["loop.csv"]
    assert Path("loop.csv").is_symlink()

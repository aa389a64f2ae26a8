"""Exports of every tab, and that the copied command computes the same."""

import dataclasses
import json
import shlex
from collections.abc import AsyncIterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input, Static

from fivtui import Parameters, branch, cli
from fivtui.io.tables import read_columns
from fivtui.maps import StabilityMap
from fivtui.maps.files import load_map
from fivtui.model import PARAMETERS, System
from fivtui.model.errors import InputError
from fivtui.orbits.curves.files import restore_branch
from fivtui.paper.claims.check import CLAIMS
from fivtui.paper.claims.claim import check
from fivtui.paper.results import PaperResults
from fivtui.results import Grid
from fivtui.scene.files import save_scene
from fivtui.scene.presets import PRESETS
from fivtui.sweeps import parse_design, scene_study
from fivtui.tradeoffs import measure as tradeoff
from fivtui.tradeoffs.files import load_tradeoff
from fivtui.tui.app import FivtuiApp
from fivtui.tui.session.command_lines import study_command
from fivtui.tui.session.editing import Editing
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import (
    answer,
    app_of,
    click_view,
    lab_of,
    palette,
    run_to_end,
    show_tab,
    until,
    until_notice,
    until_shown,
)

BASE = PRESETS["base"]


EDITED = {"F": "60", "t_end": "20", "start": "0, 0, -0.5, 0"}


@pytest.fixture
async def pilot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Pilot[None]]:
    monkeypatch.chdir(tmp_path)
    async with FivtuiApp().run_test(size=(100, 30)) as running_pilot:
        await running_pilot.pause()
        for name, text in EDITED.items():
            app_of(running_pilot).session.set_text(name, text)
        lab_of(running_pilot).show_inputs()
        yield running_pilot


async def export_file(pilot: Pilot[None], key: str, name: str, title: str) -> Path:
    await pilot.press(key)
    await until_shown(pilot, title)
    await answer(pilot, name)
    await until_notice(pilot, f"written to {name} in {Path.cwd()}")
    return Path(name)


async def check_refusal(pilot: Pilot[None], key: str, message: str) -> None:
    await pilot.press(key)
    await until_notice(pilot, message)
    assert not pilot.app.screen.query("#path")


async def copy_command(pilot: Pilot[None]) -> list[str]:
    pilot.app.copy_to_clipboard("")
    # `when_ready`: as soon as the pane of the tab exists.
    lab_of(pilot).tab_book.when_ready(lab_of(pilot).copy_command)
    await until(pilot, lambda: bool(pilot.app.clipboard))
    command = shlex.split(pilot.app.clipboard)
    assert command[0] == "fivtui"
    return command[1:]


def run_command(arguments: Sequence[str], *options: str) -> None:
    cli.commands.main([*arguments, *options], standalone_mode=False)


def is_picture(path: Path) -> bool:
    return path.read_bytes().startswith((b"\x89PNG", b"%PDF", b"<?xml"))


async def test_stability_is_exported_and_its_command_gives_the_same_file(
    pilot: Pilot[None],
) -> None:
    await show_tab(pilot, "alt+2")
    await until_shown(pilot, "Re λ (1/s)")
    assert is_picture(await export_file(pilot, "f6", "a.png", "Export the figure of the stability"))
    exported = await export_file(pilot, "f7", "a.csv", "Export the data of the stability")
    arguments = await copy_command(pilot)
    assert arguments == ["stability", "--set", "F=60"]
    # Without the search for safe friction, which is cancelled in this laboratory, too.
    run_command(arguments, "--no-search", "--out", "b.csv")
    assert exported.read_bytes() == Path("b.csv").read_bytes()
    data = json.loads((await export_file(pilot, "f7", "a.json", "Export the data of")).read_text())
    assert data["growth_rate"] == app_of(pilot).session.stability().growth_rate
    # The file of the open scene is refused as an export path.
    scene_path = Path("mine.toml")
    save_scene(BASE, scene_path)
    scene_bytes = scene_path.read_bytes()
    Path("link.png").symlink_to(scene_path)
    app_of(pilot).session.source = str(scene_path)
    await pilot.press("f6")
    await until_shown(pilot, "Export the figure of the stability")
    pilot.app.screen.query_one("#path", Input).value = "link.png"
    await pilot.pause()
    # A second Enter does not confirm it.
    for _ in range(2):
        await pilot.press("enter")
        await until_shown(pilot, "the same file as the scene opened")
    assert Path("link.png").is_symlink()
    assert scene_path.read_bytes() == scene_bytes


async def test_a_sweep_is_exported_and_its_command_gives_the_same_file(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+6")
    await check_refusal(pilot, "f6", "no sweep to export yet: press Sweep")
    pilot.app.screen.query_one("#sweep-input", Input).value = "mu=0.2:0.8:4"
    arguments_before = await copy_command(pilot)
    await pilot.press("f10")
    await until_shown(pilot, "8 transients")
    arguments = await copy_command(pilot)
    assert arguments == arguments_before
    assert is_picture(await export_file(pilot, "f6", "a.svg", "Export the figure of the sweep"))
    exported = await export_file(pilot, "f7", "a.csv", "Export the data of the sweep")
    run_command(arguments, "--out", "b.csv")
    assert exported.read_bytes() == Path("b.csv").read_bytes()
    # The copied command is that of the displayed result, without later edits.
    app_of(pilot).session.set_text("F", "70")
    assert await copy_command(pilot) == arguments
    await pilot.press("f7")
    await until_shown(pilot, "base-sweep-mu.csv")
    await answer(pilot, "a.csv")
    await until_shown(pilot, "a.csv exists. Overwrite it?")


async def test_a_map_is_exported_and_its_command_gives_the_same_file(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+3")
    # By default 121 values of μ times 93 of F.
    await until_shown(pilot, "11253 points")
    await click_view(pilot, "critical-mu")
    range_input = pilot.app.screen.query_one("#map-input", Input)
    range_input.value = "c1=0.1:1.5:7 k_nl=1:500:5:log"
    range_input.focus()
    await pilot.press("enter")
    await until_shown(pilot, "35 points")
    await until_shown(pilot, "k_nl (N/m^3)")
    await until(pilot, lambda: "critical-mu" in lab_of(pilot).tab_book.pane.command_line())  # type: ignore[union-attr]
    arguments = await copy_command(pilot)
    assert is_picture(await export_file(pilot, "f6", "a.pdf", "Export the figure of the map"))
    for suffix in (".csv", ".json"):
        exported = await export_file(pilot, "f7", f"a{suffix}", "Export the data of the map")
        assert load_map(exported).parameters.F == 60.0
    run_command(arguments, "--out", "b.csv")
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()
    # The palette lists the exports of the visible tab.
    await pilot.press("ctrl+p")
    await until_shown(pilot, "Export the data of the map…")
    await until_shown(pilot, "F7: .csv, .npz, .parquet, .json")
    await pilot.press("escape")
    await palette(pilot, "copy the command")
    await until_shown(pilot, "fivtui map --set F=60 --over c1")
    await pilot.press("escape")
    await show_tab(pilot, "alt+6")
    await palette(pilot, "copy the command")
    await until_shown(pilot, "fivtui sweep")
    await pilot.press("escape")
    await palette(pilot, "export the")
    await until_shown(pilot, "No matches found")


async def test_a_trade_off_is_exported_and_its_command_measures_the_same_scene(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Measure errors and times of the methods for 0.2 s of CPU time in place of 7 s.
    monkeypatch.setattr(tradeoff, "QUICK_S", 0.2)
    await show_tab(pilot, "alt+8")
    await check_refusal(pilot, "f7", "no trade-off to export yet: press Measure")
    await pilot.press("f10")
    await until_shown(pilot, "taylor (compiled) tol=")
    assert is_picture(await export_file(pilot, "f6", "a.svg", "Export the figure of the trade-off"))
    await export_file(pilot, "f7", "a.json", "Export the data of the trade-off")
    await export_file(pilot, "f7", "a.csv", "Export the data of the trade-off")
    arguments = await copy_command(pilot)
    run_command(arguments, "--out", "b.csv")
    scenes = [load_tradeoff(Path(name)).scene for name in ("a.json", "a.csv", "b.csv")]
    for scene in scenes:
        assert dataclasses.replace(scene, name="x") == dataclasses.replace(scenes[0], name="x")
    assert (scenes[0].t_end, scenes[0].start) == (20.0, (0.0, 0.0, -0.5, 0.0))


async def test_figures_and_claims_of_the_paper_are_exported_and_their_commands_give_the_same(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    await show_tab(pilot, "alt+0")
    await until_shown(pilot, "what it shows")
    pilot.app.screen.query_one("#figures").focus()
    await check_refusal(pilot, "f6", "Fig. 2a is not computed yet: Enter in the list of figures")
    await pilot.press("j", "enter")
    await until_shown(pilot, "figure 2b computed")
    assert is_picture(await export_file(pilot, "f6", "a.png", "Export the figure of Fig. 2"))
    exported = await export_file(pilot, "f7", "a.csv", "Export the data of Fig. 2b")
    arguments = await copy_command(pilot)
    assert arguments == ["figures", "2", "--out", "figures"]
    run_command(arguments)
    assert exported.read_bytes() == Path("figures/fig-02b.csv").read_bytes()
    # An export from the list is the paper's figure.
    await click_view(pilot, "figures")
    await pilot.pause()
    await export_file(pilot, "f6", "list.png", "Export the figure of Fig. 2")
    assert Path("list.png").read_bytes() == Path("figures/fig-02.png").read_bytes()
    await click_view(pilot, "figure")
    await export_file(pilot, "f7", "a.npz", "Export the data of Fig. 2b")
    np.testing.assert_array_equal(np.load("a.npz")["y_e"], read_columns(exported, "figure")["y_e"])

    await click_view(pilot, "claims")
    pane: Any = lab_of(pilot).tab_book.pane
    await until(pilot, lambda: pane.view == "claims")
    await check_refusal(pilot, "f7", "no claims to export yet: press Check")
    await check_refusal(pilot, "f6", "claims have no figure: F7 exports them")
    assert await copy_command(pilot) == ["claims"]
    claims = CLAIMS[:2]
    checked = [check(claim, PaperResults(workers=1)) for claim in claims]
    pane.show_result(checked)
    await until(pilot, lambda: "claims done in" in lab_of(pilot).session.reports[-1])
    exported_claims = {
        suffix: await export_file(pilot, "f7", f"claims{suffix}", "Export the data of the claims")
        for suffix in (".md", ".json", ".csv")
    }
    capsys.readouterr()
    monkeypatch.setattr("fivtui.paper.check_claims", lambda **_: checked)
    run_command(["claims", "--markdown"])
    assert exported_claims[".md"].read_text() == capsys.readouterr().out
    run_command(["claims", "--json"])
    assert json.loads(exported_claims[".json"].read_text()) == json.loads(capsys.readouterr().out)
    assert exported_claims[".csv"].read_text().splitlines()[1].startswith(claims[0].id)


# Command lines without files


def split_command(line: str) -> list[str]:
    return shlex.split(line)[1:]


def test_command_lines_name_the_preset_and_the_options_that_differ_from_it() -> None:
    ignored = PRESETS["separation-ignored"]
    origin = Editing(ignored, "separation-ignored")
    assert split_command(study_command("stability", ignored, origin)) == [
        "stability",
        "separation-ignored",
    ]
    assert split_command(study_command("run", BASE, origin)) == ["simulate"]
    # The command of a trade-off has no method, because it measures all of them.
    changed = dataclasses.replace(ignored.with_values({"F": 90.0}), t_end=7.0, method="rk4")
    assert split_command(study_command("trade-off", changed, origin)) == [
        *("tradeoff", "separation-ignored", "--set", "F=90", "--t-end=7")
    ]
    # A method of fixed step has no tolerance.
    with_step = dataclasses.replace(BASE, method="rk4", tol=1e-5)
    assert split_command(study_command("run", with_step, Editing(BASE, ""))) == [
        *("simulate", "--method=rk4")
    ]
    assert split_command(study_command("trade-off", changed, Editing(BASE, "")))[-2:] == [
        "--ignore-separation",
        "--t-end=7",
    ]


# A set with a stable branch of twice the period from μ = 5.702 on.
WITH_DOUBLING = Parameters(
    m=4.5, k1=173.0, k2=142.0, k3=28.0, c1=1.13, c2=0.58, F=176.0, k_nl=33.0, mu=4.5
)


@pytest.mark.parametrize("origin", ["hopf", "cycle"])
@pytest.mark.parametrize("is_printed", [False, True])
def test_the_command_line_of_a_branch_of_twice_the_period_computes_it_again(
    origin: Literal["hopf", "cycle"],
    is_printed: bool,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = branch(WITH_DOUBLING, "mu", low=0.0, high=10.0, origin=origin, doubled=True)
    if is_printed:
        # As by `fivtui branch --json`: without the set's own μ.
        path = tmp_path / "branch.json"
        path.write_text(json.dumps(result.to_dict()), encoding="utf-8")
        result = restore_branch(path)
    if is_printed and origin == "cycle":
        with pytest.raises(InputError, match="its file lacks the scene's value of mu"):
            study_command("branch", result, Editing(BASE, ""))
        return
    line = study_command("branch", result, Editing(BASE, ""))
    assert line.endswith(f"--vary mu=0.0:10.0 --from {origin} --doubled")
    assert cli.run([*split_command(line), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(result.to_dict()))


def test_a_doubled_branch_without_a_known_start_has_no_command_line() -> None:
    result = branch(WITH_DOUBLING, "mu", low=0.0, high=10.0, doubled=True)
    from_file = dataclasses.replace(result, origin="file")
    # Of two Hopf points along k1 the set's own k1 would select one.
    k1 = result.points[0].value
    several = dataclasses.replace(
        result, system=System(Parameters(k1=k1)), name="k1", low=5.0, high=500.0
    )
    for unrepeatable, reason in ((from_file, "no option gives"), (several, "value of k1")):
        with pytest.raises(InputError, match=f"no command repeats it: .*{reason}"):
            study_command("branch", unrepeatable, Editing(BASE, ""))


@pytest.mark.parametrize(
    ("texts", "options", "expected"),
    [
        (["F=20:80:4"], {}, "--vary F=20:80:4"),
        (["F=1:80:4:log", "x0=0.5,1"], {}, "--vary F=1:80:4:log --vary x0=0.5,1"),
        (["F=1,2", "mu=1,2"], {"kind": "list"}, "--vary F=1,2 --vary mu=1,2 --design list"),
        (
            ["F=1:9:log"],
            {"kind": "sobol", "count": 8, "seed": 2},
            "--vary F=1:9:log --design sobol --count 8 --seed 2",
        ),
    ],
)
# In each of the cases separation is considered or ignored.
@pytest.mark.parametrize("cases", [(True,), (False,), (True, False)])
def test_the_command_line_of_a_sweep_reads_back_as_the_sweep(
    texts: list[str],
    options: dict[str, Any],
    expected: str,
    cases: tuple[bool, ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    design = parse_design(texts, **{"kind": "product", **options})
    scene = dataclasses.replace(BASE.with_values({"k1": 90.0}), t_end=5.0, tol=1e-8)
    study = scene_study(scene, design, cases=cases, outputs=("stable",))
    built_studies: list[Any] = []
    # The replacement returns no sweep, so that commands end in an AttributeError.
    store_study = lambda study, *_, **__: built_studies.append(study)  # noqa: E731
    monkeypatch.setattr("fivtui.sweeps.sweep_in_memory", store_study)
    for name in ("", "separation-ignored", "coexistence"):
        origin = Editing(PRESETS[name or "base"], name)
        line = study_command("sweep", study, origin)
        assert expected in line
        built_studies.clear()
        with pytest.raises(AttributeError):
            run_command(split_command(line))
        assert built_studies == [study]


@pytest.mark.parametrize("accuracy", [(), (("peak", 1e-4), ("final", 1e-3)), (("peak", 1e-2),)])
def test_command_lines_with_error_targets_omit_the_tolerance_that_follows_from_them(
    accuracy: tuple[tuple[str, float], ...],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    path = tmp_path / "scene.toml"
    saved = dataclasses.replace(BASE, t_end=5.0, accuracy=(("peak", 1e-2),))
    save_scene(saved, path)
    scene = dataclasses.replace(BASE, t_end=5.0, tol=1e-8, accuracy=accuracy)
    study = scene_study(scene, parse_design(["F=20,30"], "product"), outputs=("y_abs",))
    built_studies: list[Any] = []
    store_study = lambda study, *_, **__: built_studies.append(study)  # noqa: E731
    monkeypatch.setattr("fivtui.sweeps.sweep_in_memory", store_study)
    for origin in (Editing(BASE, ""), Editing(saved, str(path))):
        built_studies.clear()
        with pytest.raises(AttributeError):
            run_command(split_command(study_command("sweep", study, origin)))
        assert built_studies == [study]
        arguments = split_command(study_command("run", scene, origin))
        run_command(arguments, "--json")
        data = json.loads(capsys.readouterr().out)
        assert set(data.get("accuracy", {}).get("asked", {})) == set(dict(accuracy))


def test_a_map_without_a_command_line_is_not_copied() -> None:
    axis = np.array([0.0, 1.0, 3.0])
    uneven = StabilityMap(
        System(BASE.parameters),
        Grid((PARAMETERS["F"], PARAMETERS["mu"]), (axis, axis)),
        "growth-rate",
        {"growth_rate": np.zeros((3, 3))},
        np.zeros((3, 3)),
    )
    with pytest.raises(InputError, match="F: its values are not evenly spaced"):
        study_command("map", uneven, Editing(BASE, ""))


async def test_in_a_browser_an_export_is_downloaded_and_nothing_stays_on_the_server(
    pilot: Pilot[None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    delivered: list[tuple[str, bytes]] = []

    def deliver(file: BytesIO, *, save_filename: str) -> None:
        delivered.append((save_filename, file.read()))

    monkeypatch.setattr(FivtuiApp, "is_web", True)
    monkeypatch.setattr(pilot.app, "deliver_binary", deliver)
    await show_tab(pilot, "alt+2")
    await pilot.press("f7")
    await until_shown(pilot, "The browser downloads the")
    path = pilot.app.screen.query_one("#path", Input)
    path.value = "somewhere/no.suffix"
    await pilot.press("enter")
    await until(pilot, lambda: "no.suffix: " in hint_of(pilot))
    assert "/" not in hint_of(pilot)
    path.value = "somewhere/stabilité 1.csv"
    await pilot.press("enter")
    await until(pilot, lambda: bool(delivered))
    ((name, data),) = delivered
    assert name == "stabilit--1.csv"
    await until_notice(pilot, f"data {name}: in the downloads folder of the browser")
    run_command(["stability", "--set", "F=60"], "--no-search", "--out", "b.csv")
    assert [file.name for file in tmp_path.iterdir()] == ["b.csv"]
    assert data == Path("b.csv").read_bytes()


def hint_of(pilot: Pilot[None]) -> str:
    """The hint of a dialog."""
    return str(pilot.app.screen.query_one("#dialog-hint", Static).render())


async def test_the_numbers_of_a_run_are_exported_with_its_figure(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    pane = lab_of(pilot).query_one(TransientPane)
    pane.show_view("result")
    export = pane.export("figure")
    assert (export.subject, export.file_name) == ("run 1", "base-1.svg")

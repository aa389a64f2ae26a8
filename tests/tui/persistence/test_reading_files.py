"""The laboratory reads and shows files that the command line wrote."""

import dataclasses
import json
from collections.abc import AsyncIterator
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot

from fivtui import cli
from fivtui.model.errors import Cancelled, InputError
from fivtui.scene.presets import PRESETS
from fivtui.studies import check_readable, kind_of
from fivtui.sweeps import parse_design, scene_study
from fivtui.sweeps.run import local_engine, sweep_to_file
from fivtui.tradeoffs import measure as tradeoff
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.file_actions import load_displayable
from tests.support.laboratory import (
    answer,
    app_of,
    chart_of,
    show_tab,
    until,
    until_notice,
    until_shown,
)

MU = "mu=0.2:0.8:4"


def run_command(*arguments: str) -> None:
    cli.commands.main([*arguments], standalone_mode=False)


@pytest.fixture(scope="module")
def written_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("written")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        # Measure errors and times of the methods for 0.2 s of CPU time in place of 7 s.
        patch.setattr(tradeoff, "QUICK_S", 0.2)
        run_command("simulate", "--t-end", "5", "--out", "run.csv")
        # --both: with separation considered and ignored.
        for name in ("sweep.csv", "sweep.parquet"):
            run_command("sweep", "--set=F=60", "--t-end=20", "--vary", MU, "--both", "--out", name)
        axes = ("--over", "mu=0:1.5:7", "--over", "F=5:100:5")
        for name in ("map.csv", "map.npz", "map.parquet"):
            run_command("map", "--set", "k_nl=50", *axes, "--out", name)
        run_command("tradeoff", "--set", "F=60", "--t-end", "5", "--out", "trade.csv")
        run_command("stability", "--out", "modes.csv")
        run_command("figures", "2", "--format", "svg", "--out", ".")
    return folder


@pytest.fixture
async def pilot(written_files: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Pilot[None]]:
    monkeypatch.chdir(written_files)
    async with FivtuiApp().run_test(size=(100, 30)) as pilot_of_app:
        await pilot_of_app.pause()
        yield pilot_of_app


async def read_result(pilot: Pilot[None], name: str, message: str) -> None:
    await pilot.press("alt+o")
    await until_shown(pilot, "Read a result")
    await answer(pilot, name)
    await until_notice(pilot, message)


def test_unreadable_and_unsuitable_files_are_refused(written_files: Path) -> None:
    (written_files / "bad.json").write_text("{")
    with pytest.raises(InputError, match="not JSON"):
        kind_of(written_files / "bad.json")
    with pytest.raises(InputError, match="suffixes"):
        check_readable(written_files / "a.doc")
    with pytest.raises(InputError, match="no such file"):
        check_readable(written_files / "a.csv")
    ranges = [f"--vary={name}=1,2" for name in ("F", "mu", "k1")]
    run_command("sweep", *ranges, "--output=stable", "--out", str(written_files / "many.csv"))
    with pytest.raises(InputError, match=r"many\.csv: a product sweep over F, mu, k1 cannot be"):
        load_displayable("sweep", written_files / "many.csv")


async def test_a_sweep_is_read_shown_and_opened(pilot: Pilot[None], written_files: Path) -> None:
    for name in ("sweep.csv", "sweep.parquet"):
        await read_result(pilot, name, f"sweep read from {name}")
        await until_shown(pilot, f"read from {name}; of F=60 (now 80)")
        await until_shown(pilot, "8 transients")
    await until_shown(pilot, "peak, considered")
    chart_view = chart_of(pilot, "sweep-chart")
    assert chart_view.chart is not None
    assert chart_view.chart.x_label == "μ"
    chart_view.focus()
    await pilot.press("c", "shift+right", "enter")
    runs = app_of(pilot).session.runs
    await until(pilot, lambda: runs.displayed is not None)
    assert runs.displayed is not None
    scene = runs.displayed.scene
    # The whole scene comes from the file, not from the edited one.
    assert (scene.parameters.F, scene.t_end) == (60.0, 20.0)
    # A point right of the middle, where the cursor began; which one depends on its step.
    assert scene.parameters.mu in (0.6000000000000001, 0.6, 0.8)
    sweep = app_of(pilot).session.studies.get("sweep")
    assert sweep is not None
    index = np.flatnonzero(
        (sweep.value.table.numbers["mu"] == scene.parameters.mu)
        & (sweep.value.table.separation == scene.separation)
    )
    peak = sweep.value.table.numbers["y_abs"][index]
    assert runs.displayed.result is not None
    assert peak == pytest.approx([runs.displayed.result.peak.y_abs])


async def test_sweeps_over_two_names_and_incomplete_ones_are_shown(
    pilot: Pilot[None], written_files: Path
) -> None:
    two_axes = (
        "--vary=y0=-1:0:3",
        "--vary=F=20:80:4",
        "--output=separations",
        "--ignore-separation",
    )
    run_command("sweep", *two_axes, "--t-end=10", "--out", "two.csv")
    await read_result(pilot, "two.csv", "sweep read from two.csv")
    await until_shown(pilot, "number of separations, separation ignored")
    chart_view = chart_of(pilot, "sweep-chart")
    chart_view.focus()
    await pilot.press("plus", "left")
    await read_result(pilot, "sweep.csv", "sweep read from sweep.csv")
    assert (chart_view.view.x, chart_view.view.y) == (None, None)
    await read_result(pilot, "two.csv", "sweep read from two.csv")
    chart_view.focus()
    await pilot.press("c", "enter")
    runs = app_of(pilot).session.runs
    await until(pilot, lambda: runs.displayed is not None)
    assert runs.displayed is not None
    assert (runs.displayed.scene.start[2], runs.displayed.scene.separation) == (-0.5, False)
    study = scene_study(
        dataclasses.replace(PRESETS["base"], t_end=5.0), parse_design(["F=20:80:6"], "product")
    )
    with pytest.raises(Cancelled):
        sweep_to_file(
            study,
            written_files / "part.csv",
            local_engine(1),
            size=2,
            progress=lambda part: part < 0.5,
        )
    await read_result(pilot, "part.csv.parts", "sweep read from part.csv.parts")
    await until_shown(pilot, "read from part.csv.parts")
    await until_shown(pilot, "of 6 transients")
    await pilot.press("f7")
    await until_notice(pilot, "the sweep is incomplete")


async def test_a_map_is_read_and_stays_until_another_is_requested(
    pilot: Pilot[None], written_files: Path
) -> None:
    for name in ("map.npz", "map.csv"):
        await read_result(pilot, name, f"map read from {name}")
        await until_shown(pilot, f"read from {name}; of k_nl=50 (now 100): F10")
    session = app_of(pilot).session
    session.set_text("c1", "0.8")
    map_chart = chart_of(pilot, "map-chart")
    assert map_chart.chart is not None
    assert map_chart.chart.backdrop is not None
    assert map_chart.chart.backdrop.values.shape == (7, 5)
    map_chart.focus()
    await pilot.press("c", "left", "enter")
    await until(pilot, lambda: session.runs.displayed is not None)
    # Values from the file replace edited ones.
    assert (session.texts["k_nl"], session.texts["c1"]) == ("50", "0.32")
    await show_tab(pilot, "alt+3")
    await pilot.press("f10")
    # By default 121 values of μ times 93 of F.
    await until_shown(pilot, "11253 points")
    # Only a map that was read is a study; a computed one follows the edited scene.
    assert session.studies.get("map") is None


async def test_a_trade_off_is_read_and_shown(
    pilot: Pilot[None], written_files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await read_result(pilot, "trade.csv", "trade-off read from trade.csv")
    await until_shown(pilot, "read from trade.csv; of F=60 (now 80)")
    await until_shown(pilot, "error of final state")
    await pilot.press("f7")
    await until_shown(pilot, "trade-tradeoff.csv")
    await pilot.press("escape")
    # The dialog for scenes also accepts results.
    await pilot.press("ctrl+o")
    await until_shown(pilot, "Open a scene or a result")
    await answer(pilot, "map.csv")
    await until_notice(pilot, "map read from map.csv")
    await show_tab(pilot, "alt+8")
    await read_result(
        pilot, "modes.csv", "modes.csv: not a run, uncertainty, sweep, trade-off, branch or map"
    )
    empty_tradeoff = json.dumps({"floor": {}, "rows": []})
    (written_files / "empty.json").write_text(empty_tradeoff)
    await read_result(pilot, "empty.json", "empty.json: not a trade-off, or damaged")
    await until_shown(pilot, "error of final")

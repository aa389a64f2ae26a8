"""A belt of finite speed in reports, figures and charts."""

import json

import pytest

from fivtui import Parameters, simulate
from fivtui.cli import run
from fivtui.scene import Scene, load_scene, save_scene
from fivtui.transient import Transient, transient_figure, transient_rows
from fivtui.tui.session.session import Session
from fivtui.tui.tabs.charts.transient import phase_chart, plotted_run, time_chart

START = (-2.0, -4.0, 0.3, 1.0)


@pytest.fixture(scope="module")
def belt() -> Transient:
    return simulate(Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4), t_end=5.0, start=START, samples=501)


def test_the_report_has_sticks_and_transitions(belt: Transient) -> None:
    rows = {row.label: row.value for row in transient_rows(belt)}
    assert rows["sticks"] == str(belt.events.sticks)
    assert f"{belt.events.transitions['forward-stick']} forward-stick" in rows["transitions"]
    assert {row.note for row in transient_rows(belt)}.isdisjoint({"valid for faster belts"})


def test_figures_shade_the_times_of_stick(belt: Transient) -> None:
    (off, held) = [
        shade for shade in transient_figure([belt]).axes[0].collections if shade.get_label()
    ]
    assert (off.get_label(), held.get_label()) == ("off the belt", "stuck to the belt")
    spans = [tuple(path.get_extents().intervalx) for path in held.get_paths()]
    assert [span for part in spans for span in part] == pytest.approx(
        [edge for interval in belt.stick_intervals for edge in interval]
    )
    assert len(transient_figure([simulate(t_end=5.0, samples=51)]).axes[0].collections) == 1


def test_charts_have_the_speed_of_the_belt_as_a_line(belt: Transient) -> None:
    plotted = plotted_run(belt)
    assert plotted is not None
    for chart in (
        phase_chart("x", [plotted], (0.0, 5.0)),
        time_chart("vx", [plotted], strip=False, x_axis=True),
    ):
        (guide,) = [guide for guide in chart.guides if guide.label == "belt"]
        assert (guide.value, guide.vertical) == (0.5, False)
    assert all(g.label != "belt" for g in phase_chart("y", [plotted], (0.0, 5.0)).guides)


def test_the_command_line_sets_and_unsets_it(capsys: pytest.CaptureFixture[str]) -> None:
    given = ["--set", "v_belt=1", "--set", "mu_s=0.9", "--set", "v_s=0.4"]
    assert run(["simulate", *given, "--t-end", "5", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    known = simulate(Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4), t_end=5.0)
    assert said["parameters"] == known.parameters.as_dict()
    assert said["events"]["transitions"] == known.events.transitions
    assert (said["events"]["sticks"], said["events"]["stick_time"]) == known.events[5:7]
    assert run(["simulate", *given, "--set", "v_belt=none", "--t-end", "5", "--json"]) == 2
    capsys.readouterr()
    assert run(["simulate", "--set", "v_belt=none", "--t-end", "1", "--json"]) == 0
    assert "v_belt" not in json.loads(capsys.readouterr().out)["parameters"]


@pytest.mark.parametrize(
    "words",
    [
        ["attractors"],
        ["branch", "--vary", "mu"],
        ["map", "--over", "mu=0.1:1:3", "--over", "F=20:80:3", "--out", "map.csv"],
        ["accuracy", "--t-end", "1"],
        ["simulate", "--t-end", "1", "--sensitivity", "mu"],
        ["simulate", "--t-end", "1", "--method", "rk4-across"],
        ["simulate", "--t-end", "1", "--method", "fmu"],
        ["tradeoff"],
    ],
)
def test_what_does_not_take_it_yet_says_so(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*words, "--set", "v_belt=1"]) == 2
    assert "v_belt = 1: must be none for " in capsys.readouterr().err


def test_scenes_and_the_form_keep_it(tmp_path: pytest.TempPathFactory) -> None:
    p = Parameters(v_belt=0.5, mu_s=0.9)
    scene = Scene(name="belt", description="", parameters=p)
    path = f"{tmp_path}/belt.toml"
    save_scene(scene, path)
    assert load_scene(path) == scene
    session = Session(scene)
    assert session.scene() == scene
    session.set_text("mu_s", "0.5")
    assert "at least mu" in session.error("mu_s")
    session.set_text("mu_s", "")
    assert session.scene().parameters == Parameters(v_belt=0.5)
    session.set_text("v_belt", "")
    assert session.scene().parameters == Parameters()
    session = Session(scene, path)
    session.set_text("v_belt", "")
    assert "--set v_belt=none" in session.command_line()

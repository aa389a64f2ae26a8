"""A belt of finite speed in reports, figures and charts."""

import json

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.charts.chart import View
from fivtui.charts.labels import quantity_label
from fivtui.cli import run
from fivtui.model.modes import Mode
from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.scene import Scene, load_scene, save_scene
from fivtui.transient import Transient, transient_rows
from fivtui.transient.charts import (
    difference_chart,
    partial_run,
    path_chart,
    phase_chart,
    plotted_run,
    time_chart,
)
from fivtui.tui.chart.picture import draw
from fivtui.tui.session.session import Session
from tests.support.laboratory import command_line
from tests.support.reading import transient_figure

START = (-2.0, -4.0, 0.3, 1.0)


@pytest.fixture(scope="module")
def belt_run() -> Transient:
    return simulate(Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4), t_end=5.0, start=START, samples=501)


def test_the_report_has_sticks_and_transitions(belt_run: Transient) -> None:
    rows = {row.label: row.value for row in transient_rows(belt_run)}
    assert rows["sticks"] == str(belt_run.events.sticks)
    assert f"{belt_run.events.transitions['forward-stick']} forward-stick" in rows["transitions"]
    # Without a belt speed, this note beside the greatest ẋ says for which belts the run is valid.
    assert {row.note for row in transient_rows(belt_run)}.isdisjoint({"valid for faster belts"})


def test_figures_shade_the_times_of_stick(belt_run: Transient) -> None:
    (separated, sticking) = [
        shade for shade in transient_figure([belt_run]).axes[0].collections if shade.get_label()
    ]
    assert (separated.get_label(), sticking.get_label()) == ("off the belt", "stuck to the belt")
    spans = [tuple(path.get_extents().intervalx) for path in sticking.get_paths()]
    assert [span for part in spans for span in part] == pytest.approx(
        [edge for interval in belt_run.stick_intervals for edge in interval]
    )
    assert len(transient_figure([simulate(t_end=5.0, samples=51)]).axes[0].collections) == 1


def test_charts_have_the_speed_of_the_belt_as_a_line(belt_run: Transient) -> None:
    plotted = plotted_run(belt_run)
    assert plotted is not None
    for chart in (
        phase_chart("x", [plotted], (0.0, 5.0)),
        time_chart("vx", [plotted], strip=False, x_axis=True),
    ):
        (guide,) = [guide for guide in chart.guides if guide.label == "belt"]
        assert (guide.value, guide.vertical) == (0.5, False)
    assert all(g.label != "belt" for g in phase_chart("y", [plotted], (0.0, 5.0)).guides)


def test_time_charts_mark_separation_and_stick_during_a_run_and_afterwards(
    belt_run: Transient,
) -> None:
    assert belt_run.trajectory is not None
    plotted = plotted_run(belt_run, "run 1")
    growing = partial_run(belt_run.trajectory, belt_run.system, belt_run.t_end, name="run 1")
    assert plotted is not None
    for chart_plot in (plotted, growing):
        for chart in (
            time_chart("y", [chart_plot], strip=True, x_axis=True),
            difference_chart("y", chart_plot, plotted, strip=True, x_axis=True),
        ):
            separated, sticking = chart.strips
            assert (separated.label, sticking.label) == ("off belt", "stick")
            for strip, intervals in (
                (separated, belt_run.separated_intervals),
                (sticking, belt_run.stick_intervals),
            ):
                # The marks begin and end at samples, 0.01 s apart, and may miss short intervals.
                marked = np.array(strip.intervals)
                long_intervals = [(begin, end) for begin, end in intervals if end - begin > 0.02]
                assert long_intervals
                for interval in long_intervals:
                    assert np.abs(marked - interval).max(axis=1).min() < 0.011
            drawn = draw(chart, View(), 90, 12).text().splitlines()
            assert [line[:8].strip() for line in drawn[-3:-1]] == ["off belt", "stick"]
            assert "█" in drawn[-2]
    fast_belt_run = plotted_run(simulate(t_end=5.0, samples=51))
    assert fast_belt_run is not None
    assert len(time_chart("y", [fast_belt_run], strip=True, x_axis=True).strips) == 1


def test_portraits_mark_where_the_slider_sticks(belt_run: Transient) -> None:
    plotted = plotted_run(belt_run, "run 1")
    assert plotted is not None
    motion = belt_run.to_columns()
    sticking = motion["mode"] == Mode.STICK
    assert 5 < sticking.sum() < sticking.size
    for chart, names in (
        (phase_chart("x", [plotted], (0.0, 5.0)), ("x", "vx")),
        (phase_chart("y", [plotted], (0.0, 5.0)), ("y", "vy")),
        (path_chart([plotted], (0.0, 5.0)), ("x", "y")),
    ):
        path, stick = chart.traces
        assert (stick.name, stick.look) == ("stick", "points")
        for trace, selection in ((path, slice(None)), (stick, sticking)):
            assert trace.x.tolist() == motion[names[0]][selection].tolist()
            assert trace.y.tolist() == motion[names[1]][selection].tolist()
    chart_of_two_runs = phase_chart("x", [plotted, plotted], (0.0, 5.0))
    assert [trace.name for trace in chart_of_two_runs.traces] == [
        "run 1",
        "run 1",
        *["run 1 stick"] * 2,
    ]
    assert belt_run.first_mode is Mode.SEPARATED
    chart_of_first_mode = phase_chart("x", [plotted], (0.0, belt_run.mode_changes[0].t))
    assert len(chart_of_first_mode.traces) == 1


def test_the_velocity_has_the_speed_of_the_belt_as_a_line_in_figures(belt_run: Transient) -> None:
    panels = transient_figure([belt_run], quantities=["vx", "y"]).axes
    horizontal_lines = [
        [
            ends[0]
            for ends in map(np.unique, (line.get_ydata() for line in panel.lines))
            if ends.size == 1
        ]
        for panel in panels
    ]
    # Both panels have a line at zero, that of ẋ also one at the belt speed.
    assert horizontal_lines == [[0.0, 0.5], [0.0]]


def test_the_command_line_sets_and_unsets_belt_parameters(
    capsys: pytest.CaptureFixture[str],
) -> None:
    settings = ["--set", "v_belt=1", "--set", "mu_s=0.9", "--set", "v_s=0.4"]
    assert run(["simulate", *settings, "--t-end", "5", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    expected_run = simulate(Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4), t_end=5.0)
    assert data["parameters"] == expected_run.parameters.as_dict()
    assert data["events"]["transitions"] == expected_run.events.transitions
    assert data["events"]["sticks"] == expected_run.events.sticks
    assert data["events"]["stick_time"] == expected_run.events.stick_time
    assert run(["simulate", *settings, "--set", "v_belt=none", "--t-end", "5", "--json"]) == 2
    assert "given twice" in capsys.readouterr().err
    assert run(["simulate", "--set", "v_belt=none", "--t-end", "1", "--json"]) == 0
    assert "v_belt" not in json.loads(capsys.readouterr().out)["parameters"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["map", "--over", "c1=0.1:1:3", "--over", "F=20:80:3", "--value", "safe-mu"],
        ["branch", "--curve", "fold", "--over", "mu=0.1:1", "--over", "F=20:80"],
    ],
)
def test_commands_without_support_refuse_a_belt_of_finite_speed(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*arguments, "--set", "v_belt=1"]) == 2
    assert "v_belt = 1: must be none for " in capsys.readouterr().err


def test_scenes_and_the_form_keep_belt_parameters(tmp_path: pytest.TempPathFactory) -> None:
    p = Parameters(v_belt=0.5, mu_s=0.9)
    scene = Scene(name="belt", description="", parameters=p)
    path = f"{tmp_path}/belt.toml"
    save_scene(scene, path)
    assert load_scene(path) == scene
    session = Session(scene)
    assert session.scene() == scene
    session.set_text("mu_s", "0.5")
    assert "at least mu" in session.field_error("mu_s")
    session.set_text("mu_s", "")
    assert session.scene().parameters == Parameters(v_belt=0.5)
    session.set_text("v_belt", "")
    assert session.scene().parameters == Parameters()
    session = Session(scene, path)
    session.set_text("v_belt", "")
    assert "--set v_belt=none" in command_line(session)


def test_the_axis_of_the_belt_speed_has_its_name_symbol_and_unit() -> None:
    label = quantity_label(ALL_PARAMETERS["v_belt"])
    assert label.startswith("Speed of the belt $v")
    assert label.endswith("(m/s)")

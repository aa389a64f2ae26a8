"""The branches tab: its chart, and the orbit that Enter loads."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.charts.chart import Cursors, View, VisibleCharts
from fivtui.charts.displayed_charts import charts_figure
from fivtui.charts.readout import points_at
from fivtui.cli import run as command
from fivtui.io import output_path, read_columns, save_json
from fivtui.model import InputError
from fivtui.orbits import branch, branch_chart
from fivtui.ranges import parse_ends
from fivtui.simulation import simulate
from fivtui.studies import kind_of, load_study, restore_study, save_study, store_study
from fivtui.tui.chart.cursor_moves import move_cursor, step_cursor
from fivtui.tui.chart.picture import MARGIN, draw
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.persistence.results import ResultStore
from fivtui.tui.tabs.export import DATA
from fivtui.tui.tabs.studies.branches import BranchesPane, nearest_cycle, orbit_scene
from tests.support.laboratory import app_of, show_tab, type_into, until, until_hidden, until_shown

BRANCH = branch(None, "mu", low=0.2, high=1.0)


def test_stable_cycles_are_full_unstable_ones_dashed_and_events_marked() -> None:
    # At the event "touch" the cycle reaches y = 0: beyond it the slider separates.
    chart = branch_chart(BRANCH, 0.7)
    traces = {trace.name: trace for trace in chart.traces}
    assert list(traces) == ["stable", "unstable", "Hopf", "touch", "fold"]
    fold = traces["fold"]
    assert fold.x[0] == pytest.approx(0.277876613, rel=1e-8)
    # Cycles are stable above the fold; the dashes have gaps and lie between fold and Hopf point.
    finite = np.isfinite(traces["stable"].x)
    assert finite.all()
    assert traces["stable"].x.max() == pytest.approx(1.0)
    dashes = traces["unstable"].x
    assert 5 < np.count_nonzero(np.diff(np.isfinite(dashes).astype(int)) == 1) < 100
    assert np.nanmin(dashes) >= fold.x[0] - 1e-9
    assert np.nanmax(dashes) <= traces["Hopf"].x[0] + 1e-9
    picture = draw(chart, View(), 90, 25).text()
    for label in ("1●stable", "2○unstable", "3 H Hopf", "5 F fold", "limit cycles", "now"):
        assert label in picture


def test_a_cursor_crosses_at_the_nearest_point_and_each_key_moves_it_to_another() -> None:
    chart = branch_chart(BRANCH, None)
    columns, rows = (60, 15)
    view = View()
    # The limits of y depend on the rows of the plot.
    draw(chart, view, 90, 25)

    def read_cursor() -> tuple[float, float]:
        (point,) = points_at(chart, view, view.cursors.first)
        assert view.cursors.first == (point.x, point.y)
        return point.x, point.y

    for position in ((0.3, 0.3), (0.8, 0.2), (0.6, 0.9)):
        move_cursor(chart, view, position)
        first_point = read_cursor()
        # A cursor position stored by another chart snaps to the same point.
        x, y = (axis.value(part) for axis, part in zip(view.axes(chart), position, strict=True))
        view_with_stored_cursor = replace(view, cursors=Cursors((x, y)))
        assert (
            draw(chart, view, 90, 25).lines[1:]
            == draw(chart, view_with_stored_cursor, 90, 25).lines[1:]
        )
        picture_lines = draw(chart, view, 90, 25).text().splitlines()[:-1]
        # The lines of the cursor fill its row and its column.
        (row,) = [line for line in picture_lines if "◆" in line]
        column = row.index("◆")
        assert all(line[column] != " " for line in picture_lines[1:])
        assert " " not in row[MARGIN:]
        for step, coordinate, sign in (
            ((1, 0), 0, 1.0), ((-1, 0), 0, -1.0), ((0, 1), 1, 1.0), ((0, -1), 1, -1.0),
        ):  # fmt: skip
            move_cursor(chart, view, position)
            # The step does not pan the plot.
            assert not step_cursor(chart, view, step, (columns, rows))
            assert sign * read_cursor()[coordinate] > sign * first_point[coordinate]
    # At the end of the branch there is no next point; the axes stay.
    for _ in range(3 * columns):
        assert not step_cursor(chart, view, (1, 0), (columns, rows))
    cursor_x, _ = read_cursor()
    assert cursor_x == pytest.approx(1.0)
    figure = charts_figure(VisibleCharts([(chart, view)]))
    line_x = [np.asarray(line.get_xdata()).tolist() for line in figure.axes[0].get_lines()]
    vertical_line_x = [cursor_x, cursor_x]
    assert vertical_line_x in line_x


def test_a_run_from_an_orbit_stays_on_it() -> None:
    stable = [point for point in BRANCH.points if point.stable]
    chosen = stable[len(stable) // 2]
    assert nearest_cycle(BRANCH, chosen.value, chosen.half_range) is chosen
    scene = orbit_scene(BRANCH, chosen)
    run = simulate(scene.parameters, t_end=scene.t_end, start=scene.start)
    assert run.steady.y_half_range == pytest.approx(chosen.half_range, rel=1e-5)
    assert run.peak.y_max == pytest.approx(chosen.y_max, rel=1e-5)


def test_a_parameter_with_a_range_is_parsed_or_refused() -> None:
    assert parse_ends("F", "") == ("F", None)
    assert parse_ends(" mu = 0.2 : 1 ", "") == ("mu", (0.2, 1.0))
    for text in ("q", "mu=1", "mu=1:2:3", "mu=a:b", ""):
        with pytest.raises(InputError):
            parse_ends(text, "μ=0.2:1")


def test_a_branch_is_stored_completely_and_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "b.json"
    store_study("branch", BRANCH, path)
    assert restore_study("branch", path) == BRANCH
    # The command's JSON has no μ of the parameter set, because μ varies: the first point gives it.
    save_json(BRANCH.to_dict(), output_path(path, force=True))
    assert kind_of(path) == "branch"
    loaded = load_study("branch", path)
    assert loaded.points == BRANCH.points
    assert loaded.parameters.mu == BRANCH.points[0].value
    save_study("branch", BRANCH, tmp_path / "b.csv")
    with pytest.raises(InputError, match="from JSON alone"):
        load_study("branch", tmp_path / "b.csv")
    path.write_text("{}")
    with pytest.raises(InputError, match="damaged"):
        restore_study("branch", path)


async def test_a_branch_is_computed_opened_exported_and_its_command_gives_the_same_file(
    pilot: Pilot[None], tmp_path: Path
) -> None:
    await show_tab(pilot, "alt+4")
    pane = pilot.app.screen.query_one(BranchesPane)
    with pytest.raises(InputError, match="press Follow"):
        pane.export(DATA)
    pane.query_one("#branch-input", Input).value = "mu=0.2"
    await pilot.press("f10")
    await until_shown(pilot, "must be NAME or NAME=LOW:HIGH")
    pane.query_one("#branch-input", Input).value = "μ=0.2:1"
    await pilot.press("f10")
    await until_shown(pilot, "Hopf 0.4394 · touch 0.3707 · fold 0.2779")
    await until_shown(pilot, "3 H Hopf 4 T touch 5 F fold")
    await until_shown(pilot, "○unstable")
    chart_view = pane.query_one("#branch-chart", ChartView)
    chart_view.focus()
    chart_view.view.cursors.first = (0.6, 4.0)
    chosen = nearest_cycle(BRANCH, 0.6, 4.0)
    await pilot.press("enter")
    session = app_of(pilot).session
    await until(pilot, lambda: session.runs.newest is not None and session.runs.active is None)
    run = session.runs.newest
    assert run is not None
    assert run.scene.parameters.mu == pytest.approx(chosen.value, rel=0.1)
    assert run.result is not None
    assert run.result.steady.y_half_range == pytest.approx(chosen.half_range, rel=0.3)

    assert list(app_of(pilot).session.studies) == ["branch"]
    files, notes = ResultStore(tmp_path / "kept").save(app_of(pilot).session.studies)
    assert (list(files), notes) == (["branch"], {})
    pane.export(DATA).write(tmp_path / "b.csv")
    assert read_columns(tmp_path / "b.csv", "branch")["mu"].size == len(BRANCH.points)
    arguments = pane.command_line().split()
    assert arguments[:2] == ["fivtui", "branch"]
    assert arguments[-4:] == ["--vary", "mu=0.2:1.0", "--from", "hopf"]
    assert command([*arguments[1:], "--out", str(tmp_path / "c.csv")]) == 0
    assert (tmp_path / "c.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


async def test_a_result_of_another_scene_is_marked_until_its_values_are_edited_back(
    pilot: Pilot[None],
) -> None:
    await pilot.resize_terminal(80, 24)
    await show_tab(pilot, "alt+4")
    pane = pilot.app.screen.query_one(BranchesPane)
    session = app_of(pilot).session
    pane.show_result(BRANCH)
    await until_shown(pilot, "Hopf 0.4394")
    # The branch does not depend on μ, along which it was followed, nor on the end of the run.
    for name, text in (("mu", "0.5"), ("t_end", "20")):
        await type_into(pilot, name, text)
    await until(pilot, lambda: session.scene().t_end == 20.0)
    assert not pane.has_class("-outdated")
    await type_into(pilot, "F", "200")
    await until_shown(pilot, "of F=80 (now 200): F10 computes again")
    await until_shown(pilot, "Branch another scene")
    await type_into(pilot, "F", "80")
    await until(pilot, lambda: not pane.has_class("-outdated"))
    await until_shown(pilot, "Hopf 0.4394")
    await until_hidden(pilot, "another scene")

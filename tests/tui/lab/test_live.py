"""The live curve: the transient follows every edit and does not add to the list of runs."""

import dataclasses
import threading
from pathlib import Path
from typing import Any

import pytest
from textual.pilot import Pilot

from fivtui.scene import PRESETS, Scene
from fivtui.tui.app import FivtuiApp
from fivtui.tui.lab.control import controller, live_control
from fivtui.tui.lab.notices import NoticeView
from fivtui.tui.persistence.state_file import session_state
from fivtui.tui.session import compute_scene
from fivtui.tui.session.jobs import Outcome
from fivtui.tui.session.live import (
    MAX_IMMEDIATE_S,
    MAX_LIVE_S,
    LiveCurve,
    LiveJob,
    Pace,
)
from fivtui.tui.tabs import SceneLoaded
from fivtui.tui.tabs.export import DATA, FIGURE
from fivtui.tui.tabs.transient import TransientPane
from tests.support.laboratory import (
    HANG_S,
    app_of,
    chart_of,
    click_view,
    focus,
    lab_of,
    run_to_end,
    show_tab,
    type_into,
    until,
    until_notice,
    until_screen,
    until_shown,
    until_still,
)

SIZE = (100, 34)
BASE = PRESETS["base"]


def live_of(pilot: Pilot[None]) -> LiveCurve:
    return app_of(pilot).session.live


def trace_names(pilot: Pilot[None], name: str = "plot-y") -> list[str]:
    chart = chart_of(pilot, f"{name}").chart
    return [] if chart is None else [trace.name for trace in chart.traces]


async def until_live(pilot: Pilot[None]) -> None:
    """Wait until the live curve is that of the edited scene."""
    session = app_of(pilot).session
    await until(
        pilot,
        lambda: session.live.curve is not None and session.live.curve.scene == session.scene(),
    )


async def test_every_step_is_drawn_over_the_previous_curve_and_no_run_is_stored(
    pilot: Pilot[None],
) -> None:
    await run_to_end(pilot)
    session, live = app_of(pilot).session, live_of(pilot)
    saved_runs = session_state(session).data["runs"]
    await focus(pilot, "m")
    await pilot.press("up")
    await until_live(pilot)
    displayed_run, first_curve = session.runs.displayed, live.curve
    assert displayed_run is not None
    assert first_curve is not None
    assert first_curve.scene.parameters.m == 5.1
    # The ghost is the previous curve, named "before".
    assert live.ghost is displayed_run.result
    await until(pilot, lambda: trace_names(pilot) == ["before", "live"])
    await until_shown(pilot, "Run keeps it")
    # Show the list of runs, in which a run is not "shown" if it is the ghost or not plotted.
    pilot.app.screen.add_class("-runs")
    await until_shown(pilot, "● 1 before")
    await until_screen(pilot, lambda text: text.count("live in ") == 1)
    await pilot.press("up")
    await until_live(pilot)
    assert live.ghost is first_curve.result
    await until_shown(pilot, "● 1 off")
    assert session_state(session).data["runs"] == saved_runs
    # In every view; without a baseline the difference is taken from the previous curve.
    await click_view(pilot, "phase")
    await until(pilot, lambda: trace_names(pilot, "phase-x") == ["before", "live"])
    await click_view(pilot, "spectrum")
    await until(pilot, lambda: trace_names(pilot, "plot-spectrum") == ["before", "live"])
    await click_view(pilot, "difference")
    await until_shown(pilot, "live − before")
    # Where one chart is shown alone, it has the axis of time.
    await pilot.resize_terminal(SIZE[0], 24)
    await until(pilot, lambda: not chart_of(pilot, "difference-P").display)
    chart = chart_of(pilot, "difference-y").chart
    assert chart is not None
    assert chart.x_axis
    await pilot.resize_terminal(*SIZE)
    await click_view(pilot, "belt")
    await until_shown(pilot, "▬slider")
    await click_view(pilot, "time")
    # Back at the stored run's scene there is no live curve.
    await pilot.press("ctrl+z", "ctrl+z")
    await until(pilot, lambda: not session.changed_fields and not live.visible)
    await until_shown(pilot, "run 1 done")
    assert trace_names(pilot) == ["run 1"]
    await until_shown(pilot, "● 1 shown")
    # A run by F5 replaces the live curve.
    await focus(pilot, "m")
    await pilot.press("up")
    await until_live(pilot)
    await run_to_end(pilot)
    assert [run.number for run in session.runs] == [1, 2]
    assert not live.visible
    await until_shown(pilot, "run 2 done")


async def test_the_scene_is_drawn_at_the_start_and_without_live_curve_a_line_names_the_key(
    pilot: Pilot[None],
) -> None:
    await show_tab(pilot, "alt+1")
    await until(pilot, lambda: trace_names(pilot) == ["live"])
    await until_shown(pilot, "amplitude of y ±4.401 m")
    await until_shown(pilot, "Run keeps it")
    assert not list(app_of(pilot).session.runs)
    await pilot.press("alt+l")
    await until_shown(pilot, "The live curve is off: press Run")
    assert trace_names(pilot) == []
    await pilot.press("alt+l")
    await until(pilot, lambda: trace_names(pilot) == ["live"])


class PausableRuns:
    """Replaces `compute_scene`: a run ends once `may_end` is set or it is stopped."""

    def __init__(self) -> None:
        self.jobs: list[LiveJob] = []
        self.may_end = threading.Event()

    def __call__(self, scene: Scene, job: LiveJob) -> Outcome[Any]:
        self.jobs.append(job)
        while not self.may_end.wait(0.005):
            if job.stopped:
                return Outcome()
        return compute_scene(scene, job)


@pytest.fixture
def pausable_runs(monkeypatch: pytest.MonkeyPatch) -> PausableRuns:
    runs = PausableRuns()
    monkeypatch.setattr(live_control, "compute_scene", runs)
    # Edits start runs at once, even on a slow machine.
    monkeypatch.setattr(live_control, "MAX_IMMEDIATE_S", HANG_S)
    # A pause lasts until `end_pause`.
    monkeypatch.setattr(controller, "_PAUSE", HANG_S)
    return runs


async def test_the_curve_follows_edits_that_were_made_in_another_tab(pilot: Pilot[None]) -> None:
    await until_live(pilot)
    await show_tab(pilot, "alt+2")
    await until_still(pilot)
    await pilot.press("alt+f", "up")
    await until_still(pilot)
    await show_tab(pilot, "alt+1")
    await until_live(pilot)


async def end_pause(pilot: Pilot[None]) -> None:
    """End the pause after which a longer run follows an edit."""
    lab = lab_of(pilot)
    await until(pilot, lambda: lab._live._pause_timer is not None and not lab.is_busy)
    timer = lab._live._pause_timer
    assert timer is not None
    timer.stop()
    assert timer._callback is not None
    timer._callback()


async def test_runs_follow_edits_at_once_or_after_a_pause_or_not_at_all(
    pausable_runs: PausableRuns,
) -> None:
    async with FivtuiApp().run_test(size=SIZE) as pilot:
        session, live, jobs = app_of(pilot).session, live_of(pilot), pausable_runs.jobs
        await show_tab(pilot, "alt+1")
        # The first run is that of the scene at the start.
        pausable_runs.may_end.set()
        await until_live(pilot)
        pausable_runs.may_end.clear()
        jobs.clear()
        await focus(pilot, "m")
        # Of several edits during a short run, only the newest is computed.
        await pilot.press("up")
        await until(pilot, lambda: len(jobs) == 1)
        await pilot.press("up", "up", "up")
        assert session.texts["m"] == "5.4"
        pausable_runs.may_end.set()
        await until_live(pilot)
        assert [job.scene.parameters.m for job in jobs] == [5.1, 5.4]
        assert not any(job.stopped for job in jobs)
        # A longer run waits for a pause, and an edit stops it.
        pausable_runs.may_end.clear()
        live.record_duration(BASE, 2.0)
        await pilot.press("up", "up")
        await until_shown(pilot, "live: new curve in about 2 s")
        await end_pause(pilot)
        await until(pilot, lambda: len(jobs) == 3)
        await pilot.press("up")
        await until(pilot, lambda: jobs[2].stopped)
        pausable_runs.may_end.set()
        await end_pause(pilot)
        await until_live(pilot)
        assert [job.scene.parameters.m for job in jobs[2:]] == [5.6, 5.7]
        # The newest measured duration replaces the earlier one.
        assert live.expected_duration(BASE) != pytest.approx(2.0)
        # Runs that take too long are left to the user; a shorter scene is live again.
        live.record_duration(BASE, 60.0)
        await pilot.press("up")
        await until_shown(pilot, "live off, a run takes 1 min 00 s; Run computes it")
        assert not live.visible
        assert len(jobs) == 4
        await type_into(pilot, "t_end", "5")
        # In proportion to t_end, 5 s instead of 100 s, from the 60 s above.
        await until_shown(pilot, "live: new curve in about 3 s")
        await end_pause(pilot)
        await until_live(pilot)
        # The figure contains the visible curves; the data are those of the live curve.
        pane = pilot.app.screen.query_one(TransientPane)
        assert [pane.export(kind).file_name for kind in (FIGURE, DATA)] == [
            "base-live.svg",
            "base-live.csv",
        ]
        # The figure of the belt view is a film.
        pane.show_view("belt")
        assert pane.export(FIGURE).file_name == "base-live-belt.gif"
        # Switch live curves off and on again.
        job_count = len(jobs)
        await pilot.press("alt+l")
        await until_notice(pilot, "live curve off")
        assert not session.live_enabled
        await type_into(pilot, "t_end", "4")
        assert not live.visible
        assert len(jobs) == job_count
        pausable_runs.may_end.clear()
        await pilot.press("alt+l")
        await until(pilot, lambda: len(jobs) > job_count)
        assert session.live_enabled
    # The end of the laboratory stops running computations.
    assert jobs[-1].stopped


async def test_an_error_is_one_line_above_the_previous_curve(
    pilot: Pilot[None], monkeypatch: pytest.MonkeyPatch
) -> None:
    await run_to_end(pilot)
    live = live_of(pilot)
    notices: list[str] = []
    monkeypatch.setattr(NoticeView, "add", lambda _, notice: notices.append(notice.text))
    # A linear unstable scene, which grows without bound.
    unstable_values = {"k_nl": 0.0, "mu": 1.5}
    scene = dataclasses.replace(
        BASE, parameters=BASE.parameters.with_values(unstable_values), separation=False, t_end=9e3
    )
    pilot.app.screen.post_message(SceneLoaded(scene, "", "grows"))
    await until(pilot, lambda: bool(live.error))
    await until_shown(pilot, "live: no result")
    # The line of the error may be cut: look for its first word.
    await until_shown(pilot, live.error.split()[0])
    assert trace_names(pilot) == ["before"]
    assert notices == ["grows"]
    # Unexpected exceptions are shown in the same way.
    monkeypatch.setattr(live_control, "compute_scene", lambda *_: 1 / 0)
    await type_into(pilot, "t_end", "10")
    await until(pilot, lambda: "unexpected ZeroDivisionError" in live.error)
    assert notices == ["grows"]
    monkeypatch.undo()
    # Invalid inputs are reported only in the form.
    await type_into(pilot, "t_end", "-")
    await until_shown(pilot, "live: waits for valid inputs")


async def test_a_scene_of_the_fmu_has_a_live_curve(pilot: Pilot[None]) -> None:
    await show_tab(pilot, "alt+1")
    await type_into(pilot, "t_end", "2")
    await pilot.press("f4")
    await until_live(pilot)
    curve = live_of(pilot).curve
    assert curve is not None
    assert curve.result.method == "fmu"
    await until(pilot, lambda: trace_names(pilot)[-1:] == ["live"])


@pytest.mark.whole
async def test_belts_of_finite_speed_and_tables_over_time_have_live_curves(
    pilot: Pilot[None],
) -> None:
    await show_tab(pilot, "alt+1")
    screen = lab_of(pilot)
    screen.action_set_belt(True)
    await until_live(pilot)
    curve = live_of(pilot).curve
    assert curve is not None
    assert curve.result.parameters.v_belt == 1.0
    brake_stop = dataclasses.replace(PRESETS["brake-stop"], t_end=2.0)
    pilot.app.screen.post_message(SceneLoaded(brake_stop, "", "stop"))
    await until(pilot, lambda: live_of(pilot).curve is not curve)
    new_curve = live_of(pilot).curve
    assert new_curve is not None
    assert new_curve.scene == brake_stop


def test_the_expected_duration_decides_when_a_run_starts() -> None:
    # Pace.IDLE: a run starts after a pause in the edits.
    live = LiveCurve()
    fmu = dataclasses.replace(BASE, method="fmu")
    assert live.pace(BASE) is Pace.AT_ONCE
    assert live.pace(fmu) is Pace.IDLE
    assert live.pace(PRESETS["brake-stop"]) is Pace.IDLE
    for seconds, pace in (
        (0.9 * MAX_IMMEDIATE_S, Pace.AT_ONCE),
        (1.1 * MAX_IMMEDIATE_S, Pace.IDLE),
    ):
        live.record_duration(fmu, seconds)
        assert live.pace(fmu) is pace
    live.record_duration(fmu, 1.1 * MAX_LIVE_S)
    assert live.pace(fmu) is Pace.OFF
    assert live.pace(dataclasses.replace(fmu, t_end=0.5 * fmu.t_end)) is Pace.IDLE
    # The duration is not known for a different kind of scene.
    assert live.pace(dataclasses.replace(fmu, separation=False)) is Pace.IDLE
    # Time before the first progress callback counts as setup.
    job = LiveJob(scene=fmu, pace=Pace.IDLE)
    job._start_time -= 2.0 * MAX_LIVE_S
    assert job.report(0.1)
    assert job.setup_time >= 2.0 * MAX_LIVE_S
    job._start_time -= 0.5 * MAX_LIVE_S
    assert job.report(0.5)
    assert job.estimated_duration == pytest.approx(MAX_LIVE_S, rel=0.1)
    job._start_time -= 0.5 * MAX_LIVE_S
    # MAX_LIVE_S after the setup the run stops.
    assert not job.report(0.6)


async def test_the_live_curve_of_changed_inputs_returns_after_a_restart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session_path = tmp_path / "session.json"
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        await run_to_end(pilot)
        await focus(pilot, "m")
        await pilot.press("up")
        await until_live(pilot)
        await show_tab(pilot, "alt+5")
    async with FivtuiApp(state=session_path).run_test(size=SIZE) as pilot:
        runs = app_of(pilot).session.runs
        await until(pilot, lambda: runs.displayed is not None and runs.displayed.result is not None)
        await show_tab(pilot, "alt+1")
        await until_live(pilot)
        await until(pilot, lambda: set(trace_names(pilot)) == {"live", "before"})


async def test_curves_are_dimmed_until_their_inputs_are_valid(pilot: Pilot[None]) -> None:
    await run_to_end(pilot)
    pane = lab_of(pilot).query_one(TransientPane)
    await type_into(pilot, "m", "-")
    await until_shown(pilot, "live: waits for valid inputs")
    assert pane.has_class("-outdated")
    await type_into(pilot, "m", "6")
    await until_live(pilot)
    await until(pilot, lambda: not app_of(pilot).session.live.is_outdated)
    assert not pane.has_class("-outdated")

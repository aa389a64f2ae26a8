"""Runs of a session, their samples, summaries and exports, without a screen."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from fivtui.equilibrium import stability, stability_rows, verdict
from fivtui.io import output_path
from fivtui.model import InputError
from fivtui.model.parameters import Parameters
from fivtui.scene.presets import PRESETS
from fivtui.scene.scene import Scene
from fivtui.simulation import simulate
from fivtui.transient import transient_rows
from fivtui.tui.session.jobs import Outcome
from fivtui.tui.session.report import late_separation_warning, result_summary, stability_summary
from fivtui.tui.session.runs import (
    MAX_RUNS,
    Run,
    Runs,
    RunState,
    execute,
    sample_times,
)
from fivtui.tui.session.scene_differences import base_scene
from fivtui.tui.session.session import Session
from fivtui.tui.tabs.export import (
    DATA,
    FIGURE,
    check_scene_path,
    run_export,
)

SHORT = dataclasses.replace(base_scene(), t_end=10.0)


def finish_run(scene: Scene = SHORT) -> Run:
    runs = Runs()
    run = runs.start(scene)
    assert runs.finish(run, execute(run))
    return run


def test_a_run_has_the_result_of_simulate() -> None:
    run = finish_run()
    assert run.state is RunState.DONE
    assert run.result is not None
    assert run.result.final == simulate(t_end=10.0).final
    assert run.result.trajectory is not None
    assert run.fraction == 1.0


def test_a_run_that_cannot_finish_fails_with_reason_and_advice() -> None:
    parameters = Parameters(k3=0.0, F=-1.0)
    run = finish_run(Scene(name="off", description="", parameters=parameters))
    assert run.state is RunState.FAILED
    assert run.result is None
    assert "no equilibrium" in run.message
    assert "use F >= 0" in run.message


def test_a_run_is_stopped_at_once_and_its_outcome_is_ignored() -> None:
    runs = Runs()
    run = runs.start(SHORT)
    outcome = execute(run)
    assert runs.stop() is run
    assert run.state is RunState.STOPPED
    assert runs.active is None
    assert not runs.finish(run, outcome)
    assert run.result is None
    assert runs.stop() is None


def test_a_stopped_computation_ends_without_result() -> None:
    runs = Runs()
    run = runs.start(dataclasses.replace(SHORT, t_end=1e6))
    runs.stop()
    assert execute(run) == Outcome()


def test_a_new_run_replaces_the_active_one() -> None:
    runs = Runs()
    first, second = runs.start(SHORT), runs.start(SHORT)
    assert (first.number, second.number) == (1, 2)
    assert first.state is RunState.STOPPED
    assert runs.active is second
    assert not runs.finish(first, Outcome(error="late"))
    assert runs.finish(second, Outcome(error="why"))
    assert (second.state, second.message) == (RunState.FAILED, "why")


def test_old_runs_are_deleted_but_numbers_are_never_reused() -> None:
    runs = Runs()
    for _ in range(MAX_RUNS + 3):
        runs.start(SHORT)
    assert [run.number for run in runs] == list(range(4, MAX_RUNS + 4))
    assert runs.find(3) is None
    assert runs.find(4) is not None


def test_the_remaining_time_follows_from_the_progress() -> None:
    run = Run(1, SHORT)
    assert run.progress_text == "0 %"
    run._start_time -= 10.0
    run.report(0.25)
    match = re.fullmatch(r"25 %, ([\d.]+) s left", run.progress_text)
    assert match is not None
    assert float(match[1]) >= 30.0
    # With error targets a finer run follows and verifies the result: its progress starts again.
    run.report(0.1)
    assert run.progress_text.startswith("10 %, ")


def test_a_run_is_outdated_once_a_field_differs() -> None:
    session = Session()
    run = session.runs.start(session.scene())
    assert not session.is_outdated(run)
    session.set_text("F", "80.0")
    assert not session.is_outdated(run)
    session.set_text("F", "81")
    assert session.is_outdated(run)
    session.set_text("F", "x")
    assert session.is_outdated(run)


@pytest.mark.parametrize("t_end", [0.05, 7.3, 100.0, 5000.0, 1e7])
@pytest.mark.parametrize("m", [1e-6, 5.0, 1e9])
def test_sample_times_cover_the_run_and_are_limited_in_number(t_end: float, m: float) -> None:
    times = sample_times(Scene(name="s", description="", parameters=Parameters(m=m), t_end=t_end))
    assert times[0] == 0.0
    assert times[-1] == t_end
    assert np.all(np.diff(times) > 0.0)
    # At most 250 000 intervals of equal length, and one up to the end time.
    assert 1000 <= times.size <= 250_002


def test_the_base_scene_is_sampled_at_hundredths_of_a_second() -> None:
    assert sample_times(base_scene())[:4].tolist() == [0.0, 0.01, 0.02, 0.03]


def test_verdicts_are_stable_unstable_or_neutral() -> None:
    base = Parameters()
    assert verdict(stability(base)) == "UNSTABLE"
    assert verdict(stability(base.with_values({"mu": 0.4}))) == "STABLE"
    undamped = base.with_values({"mu": 0.2, "c1": 0.0, "c2": 0.0})
    assert verdict(stability(undamped)) == "NEUTRAL"


def test_the_summary_has_growth_rate_frequency_critical_mu_and_equilibrium() -> None:
    lines = stability_summary(stability(Parameters()))
    assert lines[0] == "UNSTABLE: growth rate +0.6304 1/s, 0.9186 Hz"
    assert lines[1] == "μ_c 0.4394 (unstable above), μ 59.3 % above"
    assert lines[2] == "x_e 0.1583 m  y_e -0.6292 m  P_e 56.37 N"
    assert all(len(line) < 50 for line in lines)


@pytest.mark.parametrize("mu", [0.69, 0.7, 0.72, 0.73])
def test_of_two_modes_of_one_frequency_the_growing_one_comes_first(mu: float) -> None:
    # Rounding orders these frequencies in different ways.
    line = stability_summary(stability(Parameters(mu=mu)))[-1]
    assert re.fullmatch(r"modes (\S+) Hz \+\S+ 1/s · \1 Hz -\S+ 1/s", line)


def test_parameters_without_coupling_have_no_critical_mu() -> None:
    parameters = Parameters(k3=0.0)
    rows = {row.label: row.value for row in stability_rows(stability(parameters))}
    assert rows["critical μ"] == "none for μ > 0"
    assert rows["critical μ, linear"] == "none"


@pytest.mark.parametrize(
    ("force", "separation", "height_note", "force_note"),
    [
        (20.0, True, "negative: contact is compressed", "in contact"),
        (0.0, False, "zero: contact without force", "in contact"),
        (-5.0, True, "positive: above the belt", "off the belt: F < 0 lifts the slider"),
        (-5.0, False, "positive: contact is stretched", "in contact"),
    ],
)
def test_notes_explain_the_sign_of_y_and_whether_the_equilibrium_is_in_contact(
    force: float, separation: bool, height_note: str, force_note: str
) -> None:
    result = stability(Parameters(F=force), separation=separation)
    notes = {row.label: row.note for row in stability_rows(result)}
    assert notes["equilibrium y"] == height_note
    assert notes["contact force"] == force_note


def test_the_summary_has_the_figures_of_the_base_scene() -> None:
    result = simulate(t_end=100.0)
    assert result_summary(result)[:2] == [
        "amplitude of y ±4.401 m, still falling",
        "74 separations · off belt 71.01 s (71 %)",
    ]
    rows = {row.label: row for row in transient_rows(result, "tol 1e-12")}
    assert rows["reattachments"].value == "73"
    assert rows["max ẋ"].value == "24.3047 m/s"
    assert rows["method"].note == "tol 1e-12"


def test_a_run_without_separation_is_labelled() -> None:
    frictionless_run = simulate(Parameters(mu=0.0), t_end=5.0)
    assert "no separation: contact is never lost" in result_summary(frictionless_run)
    run_ignoring_separation = simulate(t_end=5.0, separation=False)
    # Case 2 of the paper.
    assert "separation ignored (Case 2)" in result_summary(run_ignoring_separation)


def test_a_stable_equilibrium_with_lasting_separation_gets_a_warning() -> None:
    scene = PRESETS["coexistence"]
    result = stability(scene.parameters)
    separating_run = simulate(scene.parameters, t_end=scene.t_end)
    assert late_separation_warning(separating_run, result).startswith(
        "stable equilibrium, but still separating at t = 79"
    )
    decaying_run = simulate(
        scene.parameters, t_end=scene.t_end, start=PRESETS["coexistence-decay"].start
    )
    assert late_separation_warning(decaying_run, result) == ""
    assert late_separation_warning(simulate(t_end=100.0), stability(Parameters())) == ""


def test_the_accuracy_of_a_fixed_step_is_not_claimed() -> None:
    assert Run(1, SHORT).accuracy_text == "tol 1e-12"
    fixed_step_scene = dataclasses.replace(SHORT, method="rk4", step=0.002)
    assert Run(1, fixed_step_scene).accuracy_text == "step 0.002 s, error not controlled"


def test_a_refused_export_gives_the_reason_and_keeps_the_file(tmp_path: Path) -> None:
    run, path = finish_run(), tmp_path / "a.csv"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        run_export(DATA, run).write(path)
    assert path.read_text() == "mine"
    run_export(DATA, run).write(output_path(path, force=True))
    assert path.read_text() != "mine"
    with pytest.raises(InputError, match="suffix"):
        run_export(FIGURE, run).write(tmp_path / "a.doc")


def test_proposed_names_are_valid_file_names() -> None:
    run = finish_run(dataclasses.replace(SHORT, name="a/b: c"))
    assert run_export(FIGURE, run).file_name == "a-b--c-1.svg"


def test_a_scene_file_has_its_suffix_and_replaces_no_file(tmp_path: Path) -> None:
    path = tmp_path / "stiff.toml"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        check_scene_path(path)
    with pytest.raises(InputError, match=r"must be one of \.toml"):
        check_scene_path(tmp_path / "stiff.txt")

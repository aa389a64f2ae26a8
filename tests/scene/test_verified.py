"""Transients computed to error targets, and scenes that require them."""

import dataclasses
import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fivtui import simulation
from fivtui.cli import run
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import Parameters
from fivtui.scene.files import load_scene, save_scene
from fivtui.scene.presets import PRESETS
from fivtui.scene.run import DivergenceError, scene_transient, simulate_to
from fivtui.simulation import simulate
from fivtui.transient.errors import Observation, divergence, finer_tol, first_tol
from fivtui.transient.request import TOL_RANGE, Request
from fivtui.transient.settings.checks import check_accuracy
from tests.references import REFERENCES


@pytest.mark.parametrize("name", sorted(REFERENCES))
@pytest.mark.parametrize("target", [1e-2, 1e-6])
def test_errors_are_within_their_targets_and_estimates(name: str, target: float) -> None:
    reference = REFERENCES[name]
    result = simulate_to(
        {"peak": target, "final": target},
        Request(
            System(reference.parameters, reference.separation),
            t_end=reference.t_end,
            start=reference.start,
        ),
    )
    run, estimate = result.transient, result.estimate
    final = (run.final.x, run.final.vx, run.final.y, run.final.vy)
    distance = max(abs(a - b) for a, b in zip(final, reference.final, strict=True))
    size = max(map(abs, reference.final))
    assert distance <= estimate.final * size + 1e-11 * size
    assert abs(run.peak.y_abs - reference.peak_y_abs) <= (estimate.peak + 1e-11) * run.peak.y_abs
    assert max(estimate.final, estimate.peak) <= target


def test_a_fixed_step_is_refined_until_the_error_is_met() -> None:
    request = Request(System(Parameters()), method="rk4", t_end=5.0)
    loose, tight = (simulate_to({"final": error}, request) for error in (1.0, 1e-5))
    assert tight.transient.stats.steps > loose.transient.stats.steps
    assert tight.runs > 2
    assert tight.estimate.final <= 1e-5


def test_an_error_below_rounding_is_refused_with_the_smallest_possible_one() -> None:
    with pytest.raises(ComputationError, match="error of final is about"):
        simulate_to({"final": 1e-16}, Request(System(Parameters())))


# Without damping, errors grow without bound: two runs diverge after some hundred seconds.
UNDAMPED = Parameters(c1=0.0, c2=0.0)


@pytest.mark.parametrize("target", [2e-4, 1e-2, 1.0])
def test_results_after_two_runs_diverge_are_refused_with_time_and_reason(target: float) -> None:
    with pytest.raises(ComputationError, match=r"diverge at t = .* switches differ") as caught:
        simulate_to({"half_range": target}, Request(System(UNDAMPED), t_end=1000.0))
    match = re.search(r"t = ([\d.]+) s", caught.value.why)
    assert match is not None
    # The advice is correct: before the stated time the same quantity is verified.
    shorter = Request(System(UNDAMPED), t_end=0.8 * float(match[1]))
    before = simulate_to({"half_range": target}, shorter)
    assert before.estimate.half_range <= target


def test_results_before_two_runs_diverge_are_still_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    args = ["simulate", "--set=c1=0", "--set=c2=0", "--t-end=1000", "--error=peak=1e-6"]
    assert run([*args, "--json"]) == 3
    printed = capsys.readouterr()
    data = json.loads(printed.out)
    assert list(data) == ["parted", "before"]
    assert f"diverge at t = {data['parted']['t']:.6g} s: {data['parted']['reason']}" in printed.err
    before = data["before"]
    assert 0.0 < before["t_end"] < data["parted"]["t"]
    # Midway between the last two switches that both runs have.
    longer = simulate(UNDAMPED, t_end=data["parted"]["t"], tol=3e-13)
    assert before["t_end"] == pytest.approx(longer.switch_times[-2:].mean(), abs=1e-3)
    error = before["accuracy"]["estimate"]
    assert error["peak"] <= 1e-6
    exact = simulate(UNDAMPED, t_end=before["t_end"], tol=3e-13)
    assert before["peak"]["y_abs"] == pytest.approx(exact.peak.y_abs, rel=1e-6)
    assert before["events"]["separations"] == exact.events.separations > 100
    assert before["events"]["first"] == pytest.approx(exact.events.first, abs=1e-9)
    assert before["events"]["last"] == pytest.approx(exact.events.last, abs=10.0 * error["events"])
    assert run(args) == 3
    printed = capsys.readouterr()
    title, *_ = printed.out.splitlines()
    assert title == f"Transient, verified up to t = {before['t_end']:.6g} s"
    assert printed.err.count("\n") == 1


def test_equal_peaks_of_runs_with_different_final_states_are_not_accepted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    true = simulate(Parameters(), t_end=10.0)
    shifts = itertools.cycle((0.0, 0.02 * true.peak.y_abs))

    def shifted_run(*_args: object, **_options: object) -> object:
        final = true.final._replace(x=true.final.x + next(shifts))
        return dataclasses.replace(true, final=final)

    monkeypatch.setattr("fivtui.scene.run.compute", shifted_run)
    with pytest.raises(
        DivergenceError, match=r"diverge at t = 10 s: .*% of the amplitude"
    ) as caught:
        simulate_to({"peak": 1.0}, Request(System(Parameters()), t_end=10.0))
    assert caught.value.before is None


def make_observation(final: float, *times: float) -> Observation:
    """Results of a run with a final x and times of switches, s."""
    return Observation(
        final=(final, 0.0, 0.0, 0.0),
        peak=1.0,
        half_range=1.0,
        switch_times=np.array(times),
        separations=len(times) // 2,
    )


# Runs agree if final states differ by at most 1 % of the amplitude, and switches by at most 1 % of
# the time scale, here 0.001 s.
@pytest.mark.parametrize(
    ("first", "second", "expected_time"),
    [
        (make_observation(1.0, 2.0, 3.0), make_observation(1.0, 2.0, 3.0), None),
        (make_observation(1.0, 2.0, 3.0), make_observation(1.009, 2.0, 3.0009), None),
        (make_observation(1.0, 2.0, 3.0), make_observation(1.02, 2.0, 3.0), 9.0),
        (make_observation(1.0, 2.0, 3.0), make_observation(1.0, 2.0, 3.002), 3.0),
        (make_observation(1.0, 2.0, 3.0), make_observation(1.0, 2.0, 3.0, 5.0, 6.0), 5.0),
        (make_observation(1.0, 2.0, 4.0, 5.0, 6.0), make_observation(1.0, 5.0, 6.0), 2.0),
    ],
)
def test_runs_diverge_at_the_first_different_switch_or_at_the_end(
    first: Observation, second: Observation, expected_time: float | None
) -> None:
    for result in (
        divergence(first, second, t_end=9.0, time_scale=0.1),
        divergence(second, first, t_end=9.0, time_scale=0.1),
    ):
        assert (None if result is None else result.t) == expected_time


@pytest.mark.parametrize(
    ("requested", "message"),
    [
        ({"peek": 1e-3}, "peak"),
        ({"peak": 0.0}, "must be above 0 and at most 1"),
        ({"peak": float("nan")}, "peak"),
    ],
)
def test_a_wrong_accuracy_request_is_refused(requested: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        check_accuracy(requested)


def test_the_accuracy_in_a_scene_file_is_met(tmp_path: Path) -> None:
    scene = dataclasses.replace(PRESETS["base"], t_end=20.0, accuracy=(("peak", 1e-4),))
    path = tmp_path / "scene.toml"
    save_scene(scene, path)
    assert "accuracy = {peak = 0.0001}" in path.read_text(encoding="utf-8")
    assert load_scene(path) == scene
    run = scene_transient(load_scene(path))
    assert run.verified is not None
    assert run.verified.estimate.peak <= 1e-4


def test_a_file_with_accuracy_and_tolerance_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("fivtui_scene = 1\ntol = 1e-6\naccuracy = {peak = 1e-3}\n", encoding="utf-8")
    with pytest.raises(InputError, match="tol: must not be given with accuracy"):
        load_scene(path)


def test_the_command_reports_the_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", "--t-end", "10", "--error", "peak=1e-4", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["accuracy"]
    assert data["asked"] == {"peak": 1e-4}
    assert 0.0 <= data["estimate"]["peak"] <= 1e-4
    assert run(["simulate", "--t-end", "10", "--error", "peak=1e-4"]) == 0
    assert "±" in capsys.readouterr().out
    assert run(["simulate", "--tol", "1e-4", "--error", "peak=1e-4"]) == 2
    assert "--error" in capsys.readouterr().err


def test_a_stability_scene_integrates_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_args: object, **_options: object) -> None:
        raise AssertionError("a transient was computed")

    monkeypatch.setattr("fivtui.scene.run.compute", refuse)
    monkeypatch.setattr(simulation, "integrate", refuse)
    path = tmp_path / "scene.toml"
    save_scene(dataclasses.replace(PRESETS["base"], outputs=("stability",)), path)
    assert run(["run", str(path), "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == {"scene", "stability"}


def test_samples_are_stored_only_if_required_and_cost_no_steps() -> None:
    scene = dataclasses.replace(PRESETS["base"], t_end=20.0)
    run, sampled_run = (
        scene_transient(scene, samples=samples).transient
        for samples in ("none", np.linspace(0.0, 20.0, 5001))
    )
    assert run.trajectory is None
    assert run.solution is sampled_run.solution is None
    trajectory = sampled_run.trajectory
    assert trajectory is not None
    stored = sum(getattr(trajectory, n).nbytes for n in ("t", "x", "vx", "y", "vy", "P"))
    assert stored == 6 * 8 * 5001
    assert sampled_run.stats.steps == run.stats.steps


def test_stored_data_grow_with_the_switches_and_not_with_the_horizon() -> None:
    def extra_bytes(t_end: float) -> int:
        run = scene_transient(dataclasses.replace(PRESETS["base"], t_end=t_end)).transient
        return run.switch_times.nbytes - 8 * (run.events.separations + run.events.reattachments)

    assert extra_bytes(10.0) == extra_bytes(200.0) == 0


def test_the_linear_scene_costs_fewer_steps_than_the_cubic_one() -> None:
    base = dataclasses.replace(PRESETS["base"], separation=False, t_end=20.0)
    linear = base.with_values({"k_nl": 0.0})
    cost = [scene_transient(scene).transient.stats.steps for scene in (linear, base)]
    assert cost[0] < cost[1] / 2


def test_run_computes_what_the_scene_requires(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = dataclasses.replace(PRESETS["base"], t_end=5.0, outputs=("trajectory",))
    path, out = tmp_path / "scene.toml", tmp_path / "run.csv"
    save_scene(scene, path)
    assert run(["run", str(path)]) == 2
    assert "--out FILE" in capsys.readouterr().err
    assert run(["run", str(path), "--out", str(out), "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == {"scene", "transient"}
    assert len(out.read_text().splitlines()) > 5001
    assert run(["run", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == {"scene", "stability", "transient"}


@given(st.floats(-16.0, 0.0).map(lambda exponent: 10.0**exponent))
def test_tolerances_that_verify_each_other_are_one_to_three_decades_apart(error: float) -> None:
    tol = first_tol({"peak": error})
    tolerances = [tol]
    while tolerances[-1] > TOL_RANGE[0]:
        tolerances.append(finer_tol(tolerances[-1]))
    assert len(tolerances) > 1
    assert tolerances[-1] == TOL_RANGE[0]
    # Two decades, except before the finest tolerance. The ratio may exceed 1000 by rounding.
    assert all(
        10.0 <= coarser / finer <= 1000.1 for coarser, finer in itertools.pairwise(tolerances)
    )


def test_a_run_to_a_stated_accuracy_delivers_samples_while_it_runs() -> None:
    # RK4 delivers parts of any run, the compiled kernel only parts of long runs.
    scene = dataclasses.replace(
        PRESETS["base"], t_end=5.0, method="rk4", accuracy=(("peak", 1e-3),)
    )
    parts: list[object] = []
    run = scene_transient(scene, samples=[0.0, 2.5, 5.0], on_samples=parts.append)
    assert run.verified is not None
    assert len(parts) >= run.verified.runs

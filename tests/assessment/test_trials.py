"""The trials at the extremes: right or refused, never wrong without a word."""

import json
from functools import partial

import pytest
from click.testing import CliRunner

from fivtui import Parameters
from fivtui.assessment.trials import (
    CONTESTANTS,
    TRIALS,
    Trial,
    Truth,
    Verdict,
    run_trial,
    run_trials,
    trials_to_dict,
    truth,
)
from fivtui.cli import commands
from fivtui.model.errors import Cancelled, InputError
from tests.references import REFERENCES

REFUSED_BY_ALL = {
    "linear-growth": "grows out of the range of numbers at t = ",
    "tol-too-small": "tol = 1e-16: must be from 1e-13",
}
RIGHT = [name for name in TRIALS if name not in REFUSED_BY_ALL]


@pytest.mark.parametrize("name", RIGHT)
def test_the_default_method_is_right_on_every_scene_that_has_an_answer(name: str) -> None:
    finding = run_trial(TRIALS[name], CONTESTANTS["taylor"])
    assert finding.verdict is Verdict.RIGHT
    assert finding.error is not None
    # Without damping and over 1e5 s the tolerance is that of a hundred periods no longer.
    assert finding.error <= max(3.0 * TRIALS[name].tol, 1e-14) or name == "long"


@pytest.mark.parametrize("name", REFUSED_BY_ALL)
@pytest.mark.parametrize("contestant", ["taylor", "taylor-interpreted"])
def test_what_has_no_answer_is_refused_with_the_reason(name: str, contestant: str) -> None:
    finding = run_trial(TRIALS[name], CONTESTANTS[contestant])
    assert finding.verdict is Verdict.REFUSED
    assert REFUSED_BY_ALL[name] in finding.reason


@pytest.mark.parametrize("contestant", ["scipy-dop853", "scipy-lsoda", "taylor-interpreted", "fmu"])
@pytest.mark.parametrize("name", ["start-on-switch", "start-at-origin", "lifted"])
def test_starts_on_the_switch_and_off_the_belt_are_right_by_every_method(
    name: str, contestant: str
) -> None:
    assert run_trial(TRIALS[name], CONTESTANTS[contestant]).verdict is Verdict.RIGHT


def test_the_stiff_scene_is_solved_by_the_implicit_methods_and_refused_by_those_it_outlasts() -> (
    None
):
    light = TRIALS["light"]
    assert run_trial(light, CONTESTANTS["scipy-radau"]).verdict is Verdict.RIGHT
    assert run_trial(light, CONTESTANTS["scipy-lsoda"]).verdict is Verdict.RIGHT
    refused = run_trial(light, CONTESTANTS["taylor-interpreted"])
    assert refused.verdict is Verdict.REFUSED
    assert "15000 steps end at" in refused.reason
    assert "stiff" in refused.reason
    assert run_trial(light, CONTESTANTS["rk4"]).verdict is Verdict.REFUSED


def test_a_wrong_result_is_called_wrong() -> None:
    # SciPy holds its tolerance locally, which is not the accuracy of the end state.
    finding = run_trial(TRIALS["tol-0.001"], CONTESTANTS["scipy-lsoda"])
    assert finding.verdict is Verdict.WRONG
    assert finding.error is not None
    assert finding.error > 0.02


def test_a_finite_answer_where_there_is_none_is_wrong() -> None:
    trial = Trial("none", "no answer", Parameters(), 1.0, truth_of=None)
    finding = run_trial(trial, CONTESTANTS["taylor"])
    assert (finding.verdict, finding.reason) == (Verdict.WRONG, "no finite answer exists")


def test_the_truth_agrees_with_the_one_that_mpmath_found() -> None:
    friction = truth(TRIALS["strong-friction"])
    other = REFERENCES["strong-friction"]
    assert friction is not None
    assert other.t_end == TRIALS["strong-friction"].t_end
    final = (friction.x, friction.vx, friction.y, friction.vy)
    assert final == pytest.approx(other.final, rel=1e-13)
    assert friction.separations == other.separations
    assert friction.separated_time == pytest.approx(other.separated_time, rel=1e-14)


def test_at_rest_on_the_switch_nothing_moves() -> None:
    assert truth(TRIALS["rest-on-switch"]) == Truth(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0)
    for contestant in ("taylor", "scipy-dop853", "scipy-radau", "scipy-lsoda", "fmu"):
        finding = run_trial(TRIALS["rest-on-switch"], CONTESTANTS[contestant])
        assert (finding.verdict, finding.error) == (Verdict.RIGHT, 0.0)


def test_trials_are_data_and_can_be_cancelled() -> None:
    found = run_trials(["lifted", "tol-too-small"], ["taylor"])
    data = json.loads(json.dumps(trials_to_dict(found), allow_nan=False))
    lifted, refused = data["trials"]
    assert lifted["parameters"]["F"] == -20.0
    assert lifted["findings"]["taylor"]["verdict"] == "right"
    assert refused["findings"]["taylor"]["error"] is None
    with pytest.raises(Cancelled):
        run_trials(["lifted"], ["taylor"], progress=lambda _part: False)
    with pytest.raises(InputError, match="did you mean lifted"):
        run_trials(["lifte"])


OURS = ("taylor", "taylor-interpreted", "rk4", "fmu")
# Some seconds each, by RK4 above all.
SHORT = ["lifted", "tol-too-small"]


def test_the_command_prints_a_table_and_no_native_method_of_ours_is_ever_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("fivtui.assessment.trials.run_trials", partial(run_trials, SHORT, OURS))
    done = CliRunner().invoke(commands, ["extremes", "--json"])
    assert done.exit_code == 0, done.stderr
    found = {trial["name"]: trial["findings"] for trial in json.loads(done.stdout)["trials"]}
    assert list(found) == SHORT
    for name, findings in found.items():
        assert set(findings) == set(OURS)
        assert all(finding["verdict"] != "wrong" for finding in findings.values()), name


@pytest.mark.whole
def test_no_native_method_of_ours_is_ever_wrong_on_any_trial() -> None:
    for name, findings in run_trials().items():
        assert set(findings) == set(CONTESTANTS)
        for contestant in OURS:
            assert findings[contestant].verdict is not Verdict.WRONG, name

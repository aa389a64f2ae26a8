"""Stress tests at extreme parameters: a method is right or refuses, and is never silently wrong.

In names of tests the switch is y = 0, where contact changes to separation.
"""

import json
from functools import partial

import pytest
from click.testing import CliRunner

from fivtui import Parameters
from fivtui.assessment.stress_tests import (
    METHODS_UNDER_TEST,
    STRESS_TESTS,
    StressTest,
    StressVerdict,
    TrueResult,
    run_stress_test,
    run_stress_tests,
    stress_tests_to_dict,
    true_result,
)
from fivtui.cli import commands
from fivtui.model.errors import Cancelled, InputError
from tests.references import REFERENCES

REFUSED_BY_ALL = {
    "linear-growth": "grows beyond the floating-point range at t = ",
    "tol-too-small": "tol = 1e-16: must be from 1e-13",
}
RIGHT = [name for name in STRESS_TESTS if name not in REFUSED_BY_ALL]


@pytest.mark.parametrize("name", RIGHT)
def test_the_default_method_is_right_on_every_scene_with_a_finite_result(name: str) -> None:
    result = run_stress_test(STRESS_TESTS[name], METHODS_UNDER_TEST["taylor"])
    assert result.verdict is StressVerdict.RIGHT
    assert result.error is not None
    # Over the 1e5 s of the test "long" errors accumulate to more than three times the tolerance.
    assert result.error <= max(3.0 * STRESS_TESTS[name].tol, 1e-14) or name == "long"


@pytest.mark.parametrize("name", REFUSED_BY_ALL)
@pytest.mark.parametrize("method", ["taylor", "taylor-interpreted"])
def test_scenes_without_a_finite_result_are_refused_with_the_reason(name: str, method: str) -> None:
    result = run_stress_test(STRESS_TESTS[name], METHODS_UNDER_TEST[method])
    assert result.verdict is StressVerdict.REFUSED
    assert REFUSED_BY_ALL[name] in result.reason


@pytest.mark.parametrize("method", ["scipy-dop853", "scipy-lsoda", "taylor-interpreted", "fmu"])
@pytest.mark.parametrize("name", ["start-on-switch", "start-at-origin", "lifted"])
def test_starts_on_the_switch_and_off_the_belt_are_right_by_every_method(
    name: str, method: str
) -> None:
    assert (
        run_stress_test(STRESS_TESTS[name], METHODS_UNDER_TEST[method]).verdict
        is StressVerdict.RIGHT
    )


def test_the_stiff_scene_is_solved_by_implicit_methods_and_refused_by_slow_ones() -> None:
    # Its mass of 1e-6 kg makes frequencies and decay rates large.
    stiff = STRESS_TESTS["light"]
    assert run_stress_test(stiff, METHODS_UNDER_TEST["scipy-radau"]).verdict is StressVerdict.RIGHT
    assert run_stress_test(stiff, METHODS_UNDER_TEST["scipy-lsoda"]).verdict is StressVerdict.RIGHT
    refused = run_stress_test(stiff, METHODS_UNDER_TEST["taylor-interpreted"])
    assert refused.verdict is StressVerdict.REFUSED
    assert "15000 steps reach" in refused.reason
    assert "stiff" in refused.reason
    assert run_stress_test(stiff, METHODS_UNDER_TEST["rk4"]).verdict is StressVerdict.REFUSED


def test_a_wrong_result_is_called_wrong() -> None:
    # SciPy's tolerance is local, per step, and does not bound the error of the end state.
    result = run_stress_test(STRESS_TESTS["tol-0.001"], METHODS_UNDER_TEST["scipy-lsoda"])
    assert result.verdict is StressVerdict.WRONG
    assert result.error is not None
    assert result.error > 0.02


def test_a_finite_result_of_a_scene_without_one_is_wrong() -> None:
    test = StressTest("none", "no answer", Parameters(), 1.0, has_result=False)
    result = run_stress_test(test, METHODS_UNDER_TEST["taylor"])
    assert (result.verdict, result.reason) == (StressVerdict.WRONG, "no finite answer exists")


def test_the_true_result_agrees_with_the_reference_by_mpmath() -> None:
    friction = true_result(STRESS_TESTS["strong-friction"])
    reference = REFERENCES["strong-friction"]
    assert friction is not None
    assert reference.t_end == STRESS_TESTS["strong-friction"].t_end
    final = (friction.x, friction.vx, friction.y, friction.vy)
    assert final == pytest.approx(reference.final, rel=1e-13)
    assert friction.separations == reference.separations
    assert friction.separated_time == pytest.approx(reference.separated_time, rel=1e-14)


def test_a_slider_at_rest_on_the_switch_stays_at_rest() -> None:
    assert true_result(STRESS_TESTS["rest-on-switch"]) == TrueResult(
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0
    )
    for method in ("taylor", "scipy-dop853", "scipy-radau", "scipy-lsoda", "fmu"):
        result = run_stress_test(STRESS_TESTS["rest-on-switch"], METHODS_UNDER_TEST[method])
        assert (result.verdict, result.error) == (StressVerdict.RIGHT, 0.0)


def test_results_are_data_and_can_be_cancelled() -> None:
    result = run_stress_tests(["lifted", "tol-too-small"], ["taylor"])
    data = json.loads(json.dumps(stress_tests_to_dict(result), allow_nan=False))
    lifted, refused = data["trials"]
    assert lifted["parameters"]["F"] == -20.0
    assert lifted["findings"]["taylor"]["verdict"] == "right"
    assert refused["findings"]["taylor"]["error"] is None
    with pytest.raises(Cancelled):
        run_stress_tests(["lifted"], ["taylor"], progress=lambda _part: False)
    with pytest.raises(InputError, match="did you mean lifted"):
        run_stress_tests(["lifte"])


OWN_METHODS = ("taylor", "taylor-interpreted", "rk4", "fmu")
# Short tests: others take seconds with RK4.
SHORT_TESTS = ["lifted", "tol-too-small"]


def test_the_command_prints_results_in_which_no_own_method_is_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        "fivtui.assessment.run_stress_tests", partial(run_stress_tests, SHORT_TESTS, OWN_METHODS)
    )
    invocation = CliRunner().invoke(commands, ["extremes", "--json"])
    assert invocation.exit_code == 0, invocation.stderr
    findings = {test["name"]: test["findings"] for test in json.loads(invocation.stdout)["trials"]}
    assert list(findings) == SHORT_TESTS
    for name, results in findings.items():
        assert set(results) == set(OWN_METHODS)
        assert all(result["verdict"] != "wrong" for result in results.values()), name


@pytest.mark.whole
def test_no_own_method_is_wrong_in_any_test() -> None:
    for name, results in run_stress_tests().items():
        assert set(results) == set(METHODS_UNDER_TEST)
        for method in OWN_METHODS:
            assert results[method].verdict is not StressVerdict.WRONG, name

"""Parameters fitted to signals and features: recovery, intervals, what is unknown, and refusals."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import tests.references
from fivtui import ComputationError, Parameters, Scene, identify, load_scene, simulate
from fivtui.cli import run as command
from fivtui.identification.features import FEATURES, compute_feature
from fivtui.identification.signals import compute_signals
from fivtui.identification.statistics import runs_test
from fivtui.model import Cancelled, InputError, Progress, System

from .generator import BASE, integrate, write_record

REFERENCES = json.loads(
    Path(tests.references.__file__).with_name("derivatives.json").read_text(encoding="utf-8")
)
T = np.linspace(0.0, 20.0, 2001)
TRUTH = {"mu": 0.6, "c1": 0.5, "k_nl": 150.0}
MOTION = integrate(TRUTH, T)
FIT = ("mu", "c1=0.05:5", "k_nl")
GROUP = ("m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl")


def record(folder: Path, noise: float = 0.0, seed: int = 0) -> Path:
    """The measured y with noise relative to its standard deviation."""
    y = MOTION[2]
    scatter = np.random.default_rng(seed).standard_normal(y.size)
    return write_record(folder / "rig.csv", T, y=y + noise * y.std() * scatter, x=MOTION[0])


def test_exact_data_recover_the_parameters_to_eight_digits(tmp_path: Path) -> None:
    result = identify(measured=record(tmp_path), fit=FIT)
    for name, truth in TRUTH.items():
        assert result.fit[name].value == pytest.approx(truth, rel=1e-8)
    assert result.converged
    assert result.fitted_until == T[-1]
    assert result.parameters.mu == result.fit["mu"].value


@pytest.mark.parametrize("noise", [0.001, 0.01, 0.1])
def test_noisy_data_recover_the_parameters_within_their_errors(
    tmp_path: Path, noise: float
) -> None:
    result = identify(measured=record(tmp_path, noise), fit=FIT)
    assert result.residual_sd["y"] == pytest.approx(noise * MOTION[2].std(), rel=0.1)
    for name, truth in TRUTH.items():
        fitted = result.fit[name]
        assert fitted.sd is not None
        assert abs(np.log(fitted.value / truth)) < 5.0 * fitted.sd
    assert result.warning is None


def coverage(tmp_path: Path, repeats: int) -> float:
    hits = []
    for seed in range(repeats):
        result = identify(measured=record(tmp_path, 0.05, seed), fit=FIT)
        for name, truth in TRUTH.items():
            fitted = result.fit[name]
            assert fitted.low is not None
            assert fitted.high is not None
            hits.append(fitted.low < truth < fitted.high)
    return float(np.mean(hits))


def test_intervals_of_95_percent_cover_the_truth(tmp_path: Path) -> None:
    # At most 3 of 60 intervals are expected to miss; more than 9 are very unlikely (0.1 %).
    assert coverage(tmp_path, 20) >= 51 / 60


@pytest.mark.whole
def test_intervals_cover_the_truth_in_90_to_98_percent_of_200_repeats(tmp_path: Path) -> None:
    assert 0.90 <= coverage(tmp_path, 200) <= 0.98


SIGNALS = ("x", "vx", "y", "vy", "P")


@pytest.mark.parametrize("start", ["static", (0.1, 0.2, -0.5, 0.3)])
@pytest.mark.parametrize("v_belt", [None, 6.0])
def test_derivatives_of_signals_are_differences_of_runs(start: Any, v_belt: float | None) -> None:
    scene = Scene("rig", "", Parameters(v_belt=v_belt), start=start)
    values = {"mu": 0.7, "k2": 50.0, "F": 80.0, "c1": 0.32, "k_nl": 100.0, "y0": -0.5}
    t = np.linspace(0.0, 8.0, 81)

    def signals(changes: dict[str, float]) -> np.ndarray:
        return compute_signals(scene, values | changes, t, SIGNALS, Progress(None))[0]

    _, slopes = compute_signals(scene, values, t, SIGNALS, Progress(None))
    for index, (name, value) in enumerate(values.items()):
        step = 1e-6 * abs(value)
        difference = signals({name: value + step}) - signals({name: value - step})
        scale = np.abs(slopes[:, :, index]).max(axis=0) + 1e-3
        assert np.abs(difference / (2.0 * step) - slopes[:, :, index]).max() < 1e-4 * scale.max()


@pytest.mark.parametrize("name", REFERENCES)
def test_derivatives_through_switches_are_those_of_25_digit_runs(name: str) -> None:
    reference = REFERENCES[name]
    names = [key for key in reference["by"] if reference["by"][key][0] is not None]
    values = {key: reference["parameters"][key] for key in names if key in BASE}
    scene = Scene(
        "rig",
        "",
        Parameters(**reference["parameters"]),
        separation=reference["separation"],
        start=reference["start"],
    )
    t = np.linspace(0.0, reference["t_end"], 33)
    states = ("x", "vx", "y", "vy")
    _, slopes = compute_signals(scene, values, t, states, Progress(None))
    for index, parameter in enumerate(values):
        expected = np.array(reference["by"][parameter][:4])
        np.testing.assert_allclose(
            slopes[-1, :, index], expected, rtol=1e-7, atol=1e-8 * np.abs(expected).max() + 1e-15
        )


@pytest.mark.parametrize("name", FEATURES)
def test_derivatives_of_features_are_differences(name: str) -> None:
    system, names = System(Parameters()), list(BASE)
    _, slopes = compute_feature(system, name, names)
    for parameter, slope in zip(names, slopes.tolist(), strict=True):
        value = BASE[parameter]
        low, high = (
            compute_feature(system.with_values({parameter: value * factor}), name, [])[0]
            for factor in (1.0 - 1e-5, 1.0 + 1e-5)
        )
        assert (high - low) / (2e-5 * value) == pytest.approx(
            slope, rel=1e-5, abs=1e-6 * np.abs(slopes).max()
        )


def check_scaling_is_named(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = [name for name in GROUP if rng.random() < 0.6] if seed % 2 else list(GROUP)
    fixes_group = len(names) < len(GROUP)
    truth = {name: BASE[name] * rng.uniform(0.8, 1.25) for name in BASE}
    t = np.linspace(0.0, 8.0, 401)
    motion = integrate(truth, t)
    path = write_record(tmp_path / f"{seed}.csv", t, y=motion[2], x=motion[0])
    result = identify(Parameters(**truth), path, fit=names or ["mu"], signals=("y", "x"))
    sentence = f"{', '.join(GROUP)} scale together: fix one"
    assert (sentence in result.unknown) == (not fixes_group)
    for name in result.fit:
        assert (result.fit[name].low is None) == (not fixes_group)


@pytest.mark.parametrize("seed", range(6))
def test_values_known_up_to_a_common_factor_are_named(tmp_path: Path, seed: int) -> None:
    check_scaling_is_named(tmp_path, seed)


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(50))
def test_values_known_up_to_a_factor_are_named_in_50_random_cases(
    tmp_path: Path, seed: int
) -> None:
    check_scaling_is_named(tmp_path, seed)


def test_a_value_without_effect_is_named(tmp_path: Path) -> None:
    # Without coupling, y does not depend on the horizontal spring.
    t = np.linspace(0.0, 2.0, 201)
    path = write_record(tmp_path / "rig.csv", t, y=integrate({"k3": 1e-9}, t)[2] + 0.1)
    result = identify(Parameters(k3=0.0), path, fit=["k1", "F"])
    assert result.unknown == ("k1 has no effect on the data: do not fit it",)
    assert result.fit["k1"].low is None
    assert result.fit["F"].low is not None


def test_several_files_share_values_and_have_their_own(tmp_path: Path) -> None:
    paths = [
        write_record(tmp_path / f"{load}.csv", T, y=integrate({"mu": 0.6, "F": load}, T)[2])
        for load in (70.0, 90.0)
    ]
    result = identify(measured=paths, fit=["mu"], own=["F"])
    assert list(result.fit) == ["mu", "F.1", "F.2"]
    values = [fitted.value for fitted in result.fit.values()]
    assert values == pytest.approx([0.6, 70.0, 90.0], rel=1e-7)


def test_the_start_is_fitted(tmp_path: Path) -> None:
    run = simulate(t_end=10.0, start=(0.3, -0.2, -1.5, 0.4), samples=1001).trajectory
    assert run is not None
    path = write_record(tmp_path / "rig.csv", run.t, y=run.y, x=run.x)
    start = ["x0", "vx0", "y0", "vy0"]
    result = identify(measured=path, fit=["mu", *start], signals=["y", "x"])
    values = [result.fit[name].value for name in start]
    assert values == pytest.approx([0.3, -0.2, -1.5, 0.4], abs=1e-8)


def test_targets_determine_as_many_values() -> None:
    truth = Parameters(mu=0.55, k_nl=130.0)
    targets = []
    for name in ("frequency", "growth-rate"):
        value, _ = compute_feature(System(truth), name, [])
        targets.append(f"{name}={value!r}±0.001")
    result = identify(fit=["mu", "k_nl"], targets=targets)
    assert result.fit["mu"].value == pytest.approx(0.55, rel=1e-9)
    assert result.fit["k_nl"].value == pytest.approx(130.0, rel=1e-9)
    assert result.warning is None


def test_a_signal_and_features_of_the_limit_cycle_are_fitted_together(tmp_path: Path) -> None:
    truth = Parameters(mu=0.6, k_nl=120.0, c2=0.4)
    value, _ = compute_feature(System(truth), "half-range", [])
    run = simulate(truth, t_end=10.0, samples=501).trajectory
    assert run is not None
    path = write_record(tmp_path / "rig.csv", run.t, y=run.y)
    result = identify(
        measured=path, fit=["mu", "k_nl", "c2"], targets=[f"half-range={value!r}+-0.01"]
    )
    values = [fitted.value for fitted in result.fit.values()]
    assert values == pytest.approx([0.6, 120.0, 0.4], rel=1e-6)


def test_a_value_at_its_bound_has_no_interval(tmp_path: Path) -> None:
    result = identify(measured=record(tmp_path, 0.01), fit=["mu", "c1=0.05:0.45", "k_nl"])
    assert result.at_bound == ("c1",)
    assert result.fit["c1"].low is None
    assert "c1 ends at a bound" in str(result.warning)
    with pytest.raises(ComputationError, match="no fitted scene"):
        result.fitted_scene()


def test_an_interval_that_reaches_a_bound_is_not_given() -> None:
    targets = ["half-range=3.5±0.1", "cycle-frequency=0.8±0.05"]
    result = identify(fit=["mu", "c1"], targets=targets)
    assert "c1 is hardly determined: its interval reaches a bound" in result.unknown
    assert result.fit["c1"].low is None


def test_a_run_that_leaves_the_record_is_not_called_fitted(tmp_path: Path) -> None:
    result = identify(Parameters(k1=130.0), record(tmp_path), fit=["mu"])
    assert result.warning is not None
    assert "only the first" in result.warning or "not independent" in result.warning


def test_cancelling_stops_the_fit(tmp_path: Path) -> None:
    with pytest.raises(Cancelled):
        identify(measured=record(tmp_path), fit=FIT, progress=lambda _: False)


@given(st.lists(st.floats(-1.0, 1.0), min_size=30, max_size=60))
@settings(max_examples=20)
def test_the_runs_test_is_a_probability(values: list[float]) -> None:
    assert 0.0 <= runs_test([np.array(values)]) <= 1.0


def test_the_runs_test_tells_noise_from_a_trend() -> None:
    noise = np.random.default_rng(5).standard_normal(1000)
    assert runs_test([noise]) > 0.01
    assert runs_test([np.sin(np.linspace(0.0, 20.0, 1000))]) < 1e-6
    assert runs_test([np.tile([1.0, -1.0], 500)]) < 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fit": []}, "--fit NAME: must be given"),
        ({"fit": ["nu"]}, "unknown parameter 'nu'"),
        ({"fit": ["mu", "mu"]}, "mu is given twice"),
        ({"fit": ["mu=1"]}, "must be NAME or NAME=LOW:HIGH"),
        ({"fit": ["mu=2:1"]}, "LOW must be below HIGH"),
        ({"fit": ["mu_s"]}, "mu_s: must have a value in the scene"),
        ({"fit": ["mu"], "own": ["F"]}, "--own F: must be given with --measured"),
        ({"fit": ["mu", "c1"], "targets": ["frequency=1±0.1"]}, "1 measured values for 2 unknowns"),
        ({"fit": ["mu"], "targets": ["frequency=1"]}, "must be NAME=VALUE±SD"),
        ({"fit": ["mu"], "targets": ["pitch=1±1"]}, "unknown target 'pitch'"),
        ({"fit": ["mu"], "targets": ["frequency=1±0"]}, "SD must be above 0"),
    ],
)
def test_wrong_requests_are_one_line_errors(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        identify(**options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "signals", "message"),
    [
        ("t,y\n0,1\n1,nan\n", ["y"], "must be finite"),
        ("t,y\n0,1\n0,2\n", ["y"], "must be ascending times"),
        ("t,y\n-1,1\n0,2\n", ["y"], "must be from 0 on"),
        ("t,y\n0,1\n1,2\n", ["y", "x"], "has no column x"),
        ("t,y\n0,1\n1,2\n", ["z"], "unknown signal 'z'"),
        ("t,y\n0,1\n", ["y"], "must be from 0 on"),
    ],
)
def test_wrong_files_are_one_line_errors(
    tmp_path: Path, text: str, signals: list[str], message: str
) -> None:
    path = tmp_path / "rig.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        identify(measured=path, fit=["mu"], signals=signals)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_fitted_scene_is_scattered_as_it_was_fitted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = record(tmp_path, 0.05), tmp_path / "fitted.toml"
    arguments = ["--measured", str(path), "--fit", "mu", "--fit", "c1", "--fit", "k_nl"]
    assert command(["identify", *arguments, "--out", str(out), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    scene = load_scene(out)
    assert scene.parameters.mu == data["fit"]["mu"]["value"]
    for name, distribution in scene.scatter:
        low, high = distribution.at([0.025, 0.975]).tolist()
        fitted = data["fit"][name]
        assert (low, high) == pytest.approx((fitted["low"], fitted["high"]), rel=1e-3)
    assert {(a, b): value for a, b, value in scene.correlation} == {
        (a, b): pytest.approx(data["correlation"][a][b])
        for a, b in (("mu", "c1"), ("mu", "k_nl"), ("c1", "k_nl"))
    }
    options = ["--samples", "256", "--output", "critical_mu", "--json"]
    assert command(["uncertainty", str(out), *options]) == 0
    study = json.loads(capsys.readouterr().out)
    assert study["inputs"].keys() == {"mu", "c1", "k_nl"}
    # Options add distributions, or replace them.
    varied = ["--vary", "F~normal:80:1", "--vary", "mu~uniform:0.5:0.6"]
    assert command(["uncertainty", str(out), *varied, *options]) == 0
    inputs = json.loads(capsys.readouterr().out)["inputs"]
    assert inputs.keys() == {"mu", "c1", "k_nl", "F"}
    assert "uniform" in json.dumps(inputs["mu"])


def test_the_command_prints_json_and_draws_the_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, plot = record(tmp_path, 0.01), tmp_path / "fit.png"
    arguments = ["--measured", str(path), "--fit", "mu", "--fit", "c1=0.1:2", "--fit", "k_nl"]
    assert command(["identify", *arguments, "--json", "--plot", str(plot)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["fit"]["mu"]["low"] < 0.6 < data["fit"]["mu"]["high"]
    assert data["not_known"] == []
    assert plot.stat().st_size > 10_000


def test_rounding_errors_of_an_exact_signal_are_not_called_dependent(tmp_path: Path) -> None:
    result = identify(measured=record(tmp_path, 0.01), fit=FIT, signals=["x", "y"])
    assert result.residual_sd["x"] < 1e-9
    assert result.warning is None

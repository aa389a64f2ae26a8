"""Maps and uncertainty on a belt of finite speed.

Safe friction, the μ below which disturbances of any size die out, is not searched on such belts.
"""

import numpy as np
import pytest

from fivtui import (
    Parameters,
    safe_friction,
    safety_map,
    simulate,
    stability,
    stability_map,
    uncertainty,
)
from fivtui.cli import run
from fivtui.equilibrium import critical_mu_derivatives
from fivtui.model import InputError, System

FALLING = Parameters(v_belt=0.4, mu=0.3, mu_s=0.5, v_s=0.4, c1=10.0)


def test_maps_have_the_values_of_each_point() -> None:
    over = {"v_belt": [0.3, 0.46, 0.6], "F": [40.0, 80.0]}
    growth = stability_map(FALLING, over)
    modes = stability_map(FALLING, over, "unstable-modes")
    critical = stability_map(FALLING, over, "critical-mu")
    for i, speed in enumerate(over["v_belt"]):
        for j, preload in enumerate(over["F"]):
            result = stability(FALLING.with_values({"v_belt": speed, "F": preload}))
            assert growth.values[i, j] == result.growth_rate
            # The excess over the stability boundary is negative on its stable side.
            assert (growth.excess[i, j] < 0.0) == result.stable
            assert modes.values[i, j] == (not result.stable)
            critical_mus = [point.mu for point in result.critical_mu if point.becomes == "unstable"]
            least_critical_mu = critical_mus[0] if critical_mus else np.nan
            assert np.array_equal(critical.values[i, j], least_critical_mu, equal_nan=True)
    assert np.isfinite(critical.values).any()
    assert (modes.values == 1.0).any()


def test_a_map_over_the_speed_of_the_belt_is_drawn(
    tmp_path: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [f"--set={name}={value}" for name, value in FALLING.as_dict().items()]
    command = ["map", *arguments, "--over", "v_belt=0.2:0.8:4", "--over", "mu=0.1:0.5:4"]
    assert run([*command, "--out", f"{tmp_path}/m.csv", "--plot", f"{tmp_path}/m.svg"]) == 0
    assert "v_belt" in capsys.readouterr().out
    assert (
        run(["map", *arguments, "--over", "F=20:80:3", "--over", "c2=0:1:3", "--value=safe-mu"])
        == 2
    )
    message = capsys.readouterr().err
    assert "v_belt = 0.4: must be none for maps of safe-mu; critical-mu and growth-rate" in message


def test_safe_friction_on_a_belt_of_finite_speed_is_refused_with_advice() -> None:
    advice = "use branch to follow limit cycles down in mu instead"
    with pytest.raises(InputError, match=rf"^v_belt = 0\.4: .*; {advice}$"):
        safe_friction(FALLING)
    with pytest.raises(InputError, match="must be none for maps of coexistence"):
        safety_map(None, {"v_belt": [0.1, 0.2], "F": [40.0, 80.0]}, "coexistence")
    with pytest.raises(InputError, match="output safe_mu: must be left out on a belt"):
        uncertainty(FALLING, vary={"mu": "uniform:0.1:0.4"}, outputs=["safe_mu"])


def test_uncertainty_has_probabilities_and_the_derivative_by_the_speed_of_the_belt() -> None:
    vary = {"mu": "uniform:0.1:0.45", "v_belt": "uniform:0.3:0.6"}
    outputs = ("growth_rate", "y_half_range")
    # `repeats` is the number of independent scramblings of the samples.
    result = uncertainty(FALLING, vary=vary, samples=32, repeats=4, t_end=5.0, outputs=outputs)
    growth = result.samples("growth_rate")
    assert result.probabilities["unstable"].value == pytest.approx(np.mean(growth > 0.0), abs=0.05)
    assert 0.0 < np.mean(growth > 0.0) < 1.0
    local = result.local["y_half_range"]
    mean = FALLING.with_values({"mu": 0.275, "v_belt": 0.45})
    half_ranges = [
        simulate(mean.with_values({"v_belt": speed}), t_end=5.0).steady.y_half_range
        for speed in (0.45 - 1e-6, 0.45 + 1e-6)
    ]
    assert local["v_belt"].derivative == pytest.approx(
        (half_ranges[1] - half_ranges[0]) / 2e-6, rel=1e-5
    )
    # The default outputs exclude those that cost much on a belt of finite speed.
    constant = uncertainty(Parameters(v_belt=1.0), vary={"mu": "uniform:0:1"}, samples=8, t_end=1.0)
    assert "critical_mu" in constant.study.outputs
    assert "safe_mu" not in constant.study.outputs
    falling = uncertainty(FALLING, vary={"mu": "uniform:0.1:0.4"}, samples=8, t_end=1.0)
    assert {"critical_mu", "safe_mu"}.isdisjoint(falling.study.outputs)


def test_derivatives_of_the_critical_friction_are_those_of_constant_friction() -> None:
    constant = Parameters(v_belt=1.0)
    assert critical_mu_derivatives(System(constant)) == critical_mu_derivatives(
        System(Parameters())
    )
    assert critical_mu_derivatives(System(FALLING)) is None


def test_a_map_says_how_many_points_are_without_verdict(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["map", "--over", "v_belt=0:1:3", "--over", "mu=0.1:0.5:2"]) == 0
    message = " ".join(capsys.readouterr().out.split())
    assert (
        "without verdict 2 of them, at F = 0 with separation, lifted and held by no spring, on a "
        "belt at rest, or with mu above mu_s"
    ) in message
    assert run(["map", "--over", "v_belt=1:2:2", "--over", "mu=0.1:0.5:2"]) == 0
    assert "without verdict" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("scattered", "message"),
    [("mu", "truncated to 0 to 0.75"), ("mu_s", "truncated to 0.7 to 100")],
)
def test_scattered_friction_is_truncated_at_the_friction_that_does_not_scatter(
    scattered: str, message: str
) -> None:
    p = Parameters(v_belt=1.0, mu_s=0.75)
    result = uncertainty(p, vary={scattered: "normal:0.72:0.05"}, samples=64, outputs=["y_max"])
    assert result.to_dict()["truncated"][0].startswith(f"{scattered}~normal:0.72:0.05: {message}")
    assert "failed" not in result.sweep.table.reasons
    drawn_values = result.sweep.table.numbers[scattered]
    assert (drawn_values.max() <= 0.75) if scattered == "mu" else (drawn_values.min() >= 0.7)
    with pytest.raises(InputError, match="must have values from"):
        uncertainty(p, vary={"mu": "uniform:0.8:0.9"}, samples=64)

"""Stiff scenes are noticed, and solved or refused with advice."""

import pytest

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.model.errors import ComputationError
from fivtui.model.slider_belt import equilibrium
from fivtui.transient.stiffness import find_stiffness
from tests.cli.test_cli import run_fivtui

LIGHT_SLIDER = Parameters(m=1e-6)


@pytest.mark.parametrize(
    "p",
    [
        Parameters(),
        Parameters(k2=1e8),
        Parameters(k_nl=1e9),
        Parameters(c1=0.0, c2=0.0),
        Parameters(m=1e-6, c1=0.0, c2=0.0),
        Parameters(F=1e6),
        Parameters(F=-5.0),
    ],
)
def test_oscillations_are_not_stiff_however_fast(p: Parameters) -> None:
    assert find_stiffness(System(p), t_end=1e3) is None


def test_a_light_slider_is_stiff_unless_the_run_is_short() -> None:
    stiffness = find_stiffness(System(LIGHT_SLIDER), t_end=100.0)
    assert stiffness is not None
    assert stiffness.decay_rate == pytest.approx(LIGHT_SLIDER.c1 / LIGHT_SLIDER.m, rel=1e-2)
    assert stiffness.motion_rate < 1e3
    # Steps of an explicit method over the 100 s that its stability needs.
    assert stiffness.steps == pytest.approx(3.6e6, rel=0.05)
    assert find_stiffness(System(LIGHT_SLIDER), t_end=0.1) is None


def test_one_strong_damper_makes_a_scene_stiff() -> None:
    p = Parameters(c1=1e6)
    stiffness = find_stiffness(System(p), t_end=100.0)
    assert stiffness is not None
    assert stiffness.decay_rate == pytest.approx(p.c1 / p.m, rel=1e-3)


def test_the_step_limit_error_names_stiffness_and_suitable_methods() -> None:
    with pytest.raises(ComputationError, match="stiff") as caught:
        simulate(LIGHT_SLIDER, max_steps=300)
    assert "scipy-lsoda" in caught.value.advice
    with pytest.raises(ComputationError) as caught:
        simulate(Parameters(), max_steps=300)
    assert "stiff" not in str(caught.value)


@pytest.mark.parametrize("method", ["scipy-radau", "scipy-lsoda"])
def test_advised_methods_solve_a_stiff_scene(method: str) -> None:
    run = simulate(LIGHT_SLIDER, method=method, tol=1e-8)
    rest = equilibrium(System(LIGHT_SLIDER))
    assert run.stats.steps < 2_000
    assert (run.final.x, run.final.y) == pytest.approx((rest.x, rest.y), rel=1e-10)
    # The overdamped slider rises from its start to the equilibrium.
    _, _, start_y, _ = run.start
    assert run.peak.y_min == pytest.approx(start_y)


def test_steps_of_fixed_length_are_limited_before_the_run() -> None:
    with pytest.raises(ComputationError, match=r"1\.45e\+08 steps .* are needed"):
        simulate(LIGHT_SLIDER, method="rk4")


def test_rk4_refuses_a_step_that_the_damping_makes_unstable() -> None:
    with pytest.raises(ComputationError, match="the damping allows steps up to about 1e-05 s"):
        simulate(Parameters(c1=1e6), method="rk4", step=1e-3, t_end=1.0)


def test_the_command_line_warns_of_stiffness_on_standard_error() -> None:
    # Require the compiled kernel: the command runs in this process, interpreted it takes seconds.
    simulate(t_end=1.0, kernel="compiled")
    process = run_fivtui("simulate", "--set", "m=1e-6", "--t-end", "0.6")
    assert process.returncode == 0
    assert "the scene is stiff" in process.stderr
    assert "--method scipy-lsoda" in process.stderr
    assert "stiff" not in process.stdout

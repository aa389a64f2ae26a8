"""The reference method RK4: its order, its agreement with Taylor steps, and its refusals."""

import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui import Parameters, simulate
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.slider_belt import State, static_start
from fivtui.transient.result import Transient
from fivtui.transient.steppers.rk4 import RungeKutta4
from tests.support.strategies import moderate_parameters, states

T_END = 4.0  # s


def end_state(step: float, *, separation: bool = True, bisect: bool = True) -> np.ndarray:
    # From well above the belt: the slider lands early and switches several times before T_END.
    integrator = RungeKutta4(
        [Parameters()], [(0.1, 0.0, 0.5, 1.0)], step=step, separation=separation, bisect=bisect
    )
    for _ in range(round(T_END / step)):
        integrator.advance()
    return integrator.state[:, 0]


def orders(errors: list[float]) -> list[float]:
    # Orders of convergence from errors at steps that halve.
    return [
        float(np.log2(coarse_error / fine_error)) for coarse_error, fine_error in pairwise(errors)
    ]


@cache
def errors(*, separation: bool, bisect: bool) -> list[float]:
    # Errors of the final state at steps that halve.
    exact = simulate(
        Parameters(), t_end=T_END, start=(0.1, 0.0, 0.5, 1.0), separation=separation
    ).final
    expected = np.array([exact.x, exact.vx, exact.y, exact.vy])
    steps = [0.02 / 2**n for n in range(5)]
    ends = [end_state(step, separation=separation, bisect=bisect) for step in steps]
    return [float(np.abs(end - expected).max()) for end in ends]


def test_with_bisection_of_switches_the_order_is_four() -> None:
    observed = orders(errors(separation=True, bisect=True))
    assert observed[-1] == pytest.approx(4.0, abs=0.25)
    assert observed[-2] == pytest.approx(4.0, abs=0.4)


def test_with_separation_ignored_the_order_is_four() -> None:
    assert orders(errors(separation=False, bisect=True))[-1] == pytest.approx(4.0, abs=0.25)


def test_without_bisection_of_switches_the_order_is_lower() -> None:
    with_bisection = errors(separation=True, bisect=True)
    without_bisection = errors(separation=True, bisect=False)
    # Over four halvings of the step, the error falls with an order of more than log₂(50)/4 = 1.4.
    assert without_bisection[-1] < 0.02 * without_bisection[0]
    assert np.mean(orders(without_bisection)) < 3.2
    assert without_bisection[-1] > 30.0 * with_bisection[-1]


def test_base_scene_agrees_with_taylor_within_its_own_error() -> None:
    fine = simulate(Parameters(), t_end=12.0, method="rk4", step=0.001)
    coarse = simulate(Parameters(), t_end=12.0, method="rk4", step=0.002)
    exact = simulate(Parameters(), t_end=12.0)

    def distance(result: Transient) -> float:
        rk4_final, exact_final = (np.array(run.final) for run in (result, exact))
        return float(np.abs(rk4_final - exact_final).max())

    assert fine.events.separations == exact.events.separations == 7
    assert distance(fine) < 1e-7
    assert distance(coarse) > 8.0 * distance(fine)
    assert fine.peak.y_abs == pytest.approx(exact.peak.y_abs, abs=1e-8)
    assert fine.switch_times == pytest.approx(exact.switch_times, abs=1e-8)


def test_parameter_sets_advanced_together_agree_with_sets_advanced_singly() -> None:
    sets = [
        Parameters(F=preload, k_nl=k) for preload, k in ((20, 50), (80, 100), (120, 0), (0, 10))
    ]
    starts = [static_start(System(p)) for p in sets]
    together = RungeKutta4(sets, starts, step=0.01)
    alone = [RungeKutta4([p], [s], step=0.01) for p, s in zip(sets, starts, strict=True)]
    for _ in range(250):
        for integrator in (together, *alone):
            integrator.advance()
    for column, integrator in enumerate(alone):
        assert together.state[:, column] == pytest.approx(integrator.state[:, 0], abs=1e-12)
        assert together.contact[column] == integrator.contact[0]


@settings(max_examples=25)
@given(moderate_parameters(), states())
def test_random_scenes_agree_with_taylor(p: Parameters, start: State) -> None:
    step = 0.004
    integrator = RungeKutta4([p], [start], step=step)
    for _ in range(250):
        integrator.advance()
    exact = simulate(p, t_end=250 * step, start=start).final
    size = 1.0 + np.abs(integrator.state).max()
    expected = [exact.x, exact.vx, exact.y, exact.vy]
    assert integrator.state[:, 0] == pytest.approx(expected, abs=2e-4 * size)


def test_a_step_too_large_for_the_stiffness_is_refused_with_a_bound_and_a_step_that_runs() -> None:
    p = Parameters(k2=1e8)
    with pytest.raises(ComputationError, match="too large for RK4 at t = 0 s") as caught:
        simulate(p, t_end=1.0, method="rk4", step=1e-3)
    bound = float(re.findall(r"up to about (\S+) s there", caught.value.why)[0])
    advised = float(re.findall(r"a smaller step, such as (\S+) s", caught.value.advice)[0])
    assert advised < bound < 1e-3
    for step in (advised, 0.95 * bound):
        simulate(p, t_end=0.01, method="rk4", step=step)
    with pytest.raises(ComputationError, match="too large"):
        simulate(p, t_end=0.01, method="rk4", step=1.05 * bound)


@pytest.mark.parametrize("step", [0.0, -0.1, float("nan"), float("inf")])
def test_a_step_that_is_not_positive_is_refused(step: float) -> None:
    with pytest.raises(InputError, match="step"):
        RungeKutta4([Parameters()], [(0.0, 0.0, 0.0, 0.0)], step=step)

"""Advice names only parameters that apply to the parameter set."""

from typing import Any

import numpy as np
import pytest

from fivtui import Parameters, simulate, simulate_batch
from fivtui.model import (
    CUBIC_CONTACT,
    SEPARATION,
    ComputationError,
    System,
    advise,
    advise_one_of,
    time_tables,
)
from fivtui.model.advice import LARGER_V_S, LESS_DAMPING
from fivtui.orbits.curves.branch_curve import ParameterLine
from fivtui.orbits.curves.origins import _advice_text
from fivtui.taylor import overflow_error, stall_error
from fivtui.transient.request import TOL_RANGE, Request
from fivtui.transient.steppers.rk4 import RungeKutta4
from fivtui.transient.stiffness import step_limit_error

SPEED_DEPENDENT_FRICTION = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4)


def test_alternatives_are_joined_as_in_a_sentence() -> None:
    assert advise_one_of(["a"]) == "use a"
    assert advise_one_of(["a", "b"]) == "use a or b"
    assert advise_one_of(["a", "b", "c"]) == "use a, b or c"


@pytest.mark.parametrize(
    ("remedy", "applying", "not_applying"),
    [
        (LARGER_V_S, {"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}, {"v_belt": 1.0, "mu_s": 0.9}),
        (LARGER_V_S, {"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}, {"v_belt": 1.0, "v_s": 0.4}),
        (LARGER_V_S, {"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}, {"mu_s": 0.9, "v_s": 0.4}),
        (LESS_DAMPING, {"c1": 0.0}, {"c1": 0.0, "c2": 0.0}),
        (LESS_DAMPING, {"c2": 0.0}, {"c1": 0.0, "c2": 0.0}),
        (CUBIC_CONTACT, {"k_nl": 0.0}, {}),
    ],
)
def test_a_remedy_is_named_only_where_it_applies(
    remedy: Any, applying: dict[str, float], not_applying: dict[str, float]
) -> None:
    remedies = (remedy, "a greater mass")
    assert advise(System(Parameters().with_values(applying)), remedies) == (
        f"use {remedy.text} or a greater mass"
    )
    assert advise(System(Parameters().with_values(not_applying)), remedies) == "use a greater mass"


def test_separation_is_advised_where_it_is_ignored() -> None:
    p, remedies = Parameters(), (SEPARATION, "a shorter run")
    assert advise(System(p, separation=False), remedies) == "use separation or a shorter run"
    assert advise(System(p, separation=True), remedies) == "use a shorter run"


def test_errors_of_the_integrators_advise_on_applicable_parameters() -> None:
    # A motion that overflows at a small state changes too fast; at a large one it has grown.
    small, large = (1e-3, 0.0, -1e-3, 0.0), (1e200, 0.0, 1e200, 0.0)
    undamped = Parameters(c1=0.0, c2=0.0)
    assert (
        overflow_error(0.0, small, System(undamped)).advice
        == "use a softer contact or a greater mass"
    )
    assert overflow_error(0.0, small, System(SPEED_DEPENDENT_FRICTION)).advice == (
        "use a larger v_s, a softer contact, less damping or a greater mass"
    )
    assert overflow_error(0.0, large, System(Parameters())).advice == "use a shorter run"
    assert overflow_error(0.0, large, System(Parameters(k_nl=0.0), separation=False)).advice == (
        "use separation, a cubic contact (k_nl above 0) or a shorter run"
    )
    # A run stalls if the motion changes faster than floats resolve time.
    assert stall_error(0.0, Parameters()).advice == "use a less stiff contact or more damping"
    assert stall_error(0.0, SPEED_DEPENDENT_FRICTION).advice.endswith(
        ", more damping or a larger v_s"
    )


@pytest.mark.parametrize("separation", [True, False])
def test_runs_and_batches_give_the_same_advice(separation: bool) -> None:
    p = Parameters(k2=186.0, k_nl=0.0, mu=90.0)
    with pytest.raises(ComputationError) as run_error:
        simulate(p, t_end=1e4, separation=separation)
    batch = simulate_batch({"mu": [90.0]}, base=p, t_end=1e4, separation=separation)
    failure = batch.failure(0)
    assert failure is not None
    assert failure.advice == run_error.value.advice
    assert ("separation" in failure.advice) is not separation


def test_fixed_steps_that_overflow_advise_on_applicable_parameters() -> None:
    p = Parameters(k2=186.0, mu=90.0, k_nl=0.0)
    stepper = RungeKutta4([Parameters(), p], [(0.0,) * 4, (1e308, 0.0, -1e308, 0.0)], step=1e-2)
    with np.errstate(all="ignore"), pytest.raises(ComputationError) as error:
        stepper.advance()
    assert error.value.advice == (
        "use a smaller step, a cubic contact (k_nl above 0) or a shorter run"
    )


def test_the_step_limit_error_advises_settings_of_the_method() -> None:
    assert step_limit_error(Request(System(Parameters())), 1.0).advice == (
        "use a shorter horizon or a larger tol"
    )
    largest_tol = Request(System(Parameters()), tol=TOL_RANGE[1])
    assert step_limit_error(largest_tol, 1.0).advice == "use a shorter horizon"
    fixed_step = Request(System(Parameters()), method="rk4")
    assert step_limit_error(fixed_step, 1.0).advice == "use a shorter horizon"
    # In messages a scene is a parameter set with the settings of its transient.
    stiff = Parameters(c2=1e8)
    error = step_limit_error(Request(System(stiff), t_end=1e3), 1.0)
    assert "the scene is stiff" in error.why
    assert error.advice == "use the method scipy-lsoda or scipy-radau"
    # One of these methods is in use already, or they cannot compute what is requested.
    for request in (
        Request(System(stiff), t_end=1e3, method="scipy-radau"),
        Request(System(stiff), t_end=1e3, sensitivities=("mu",)),
        Request(System(stiff, over_time=time_tables({"F": [(0.0, 80.0), (1.0, 90.0)]})), t_end=1e3),
    ):
        error = step_limit_error(request, 1.0)
        assert "the scene is stiff" in error.why
        assert error.advice == "use a shorter horizon or a larger tol"


def test_a_branch_without_damping_is_not_advised_to_begin_at_a_hopf_point() -> None:
    undamped = Parameters(c1=0.0, c2=0.0)
    for p, name, has_hopf in (
        (Parameters(), "mu", True),
        (undamped, "mu", False),
        (undamped, "c1", True),
    ):
        # The cycles of the system as the parameter `name` varies from 0 to 1.
        line = ParameterLine(System(p), name, (0.0, 1.0))
        assert ("Hopf" in _advice_text(line)) is has_hopf

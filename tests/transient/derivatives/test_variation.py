"""Derivatives of transients, against differences of 25-digit runs, identities and each other.

A `Seed` is a direction of the derivative: a change of the start (x, ẋ, y, ẏ) and of parameters.
"""

import json
import math
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import assume, example, given, settings, strategies as st
from scipy.linalg import expm

import tests.references
from fivtui import Parameters, simulate
from fivtui.model import Progress, System
from fivtui.model.errors import Cancelled, ComputationError
from fivtui.model.modes import Mode
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import (
    State,
    accelerations,
    equilibrium,
    jacobian,
    mode_of,
)
from fivtui.taylor.variation import Seed
from fivtui.transient.derivatives.variation import (
    EXTREMES,
    START_SEEDS,
    Variation,
    compute_variation,
)
from fivtui.transient.request import Kernel, Request
from fivtui.transient.settings.checks import START_THRESHOLD
from tests.support.strategies import moderate_parameters, states

REFERENCES: Final[dict[str, Any]] = json.loads(
    Path(tests.references.__file__).with_name("derivatives.json").read_text(encoding="utf-8")
)
KERNELS: Final[tuple[Kernel, ...]] = ("compiled", "interpreted")
AT_REST: Final[State] = (0.0, 0.0, 0.0, 0.0)
NO_CHANGE: Final[State] = (0.0, 0.0, 0.0, 0.0)
PARAMETER_SEEDS: Final = tuple(Seed(NO_CHANGE, {name: 1.0}) for name in PARAMETERS)


def flow_derivatives(
    p: Parameters, start: State, duration: float, *, separation: bool = True
) -> Variation:
    request = Request(System(p, separation), t_end=duration, tol=1e-13, start=start)
    return compute_variation(request, START_SEEDS)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("name", ["drawn-1", "drawn-2"])
def test_derivatives_are_differences_of_25_digit_runs(name: str, kernel: Kernel) -> None:
    reference = REFERENCES[name]
    names = reference["quantities"]
    request = Request(
        System(Parameters(**reference["parameters"])),
        t_end=reference["t_end"],
        tol=1e-13,
        start=reference["start"],
        kernel=kernel,
    )
    variation = compute_variation(request, [*PARAMETER_SEEDS, *START_SEEDS])
    expected = np.array(list(reference["by"].values())).T
    assert list(reference["by"]) == [*PARAMETERS, "x0", "vx0", "y0", "vy0"]
    scale = np.abs(expected[:4]).max(axis=0)
    assert (np.abs(variation.derivatives - expected[:4]) < 1e-11 * scale).all()
    for extreme in ("y_min", "y_max", "vx_max"):
        derivatives = variation.extreme_derivatives[EXTREMES.index(extreme)]
        assert (np.abs(derivatives - expected[names.index(extreme)]) < 1e-11 * scale).all(), extreme


@settings(max_examples=8)
@given(moderate_parameters(), states(), st.floats(0.1, 3.0), st.booleans())
def test_compiled_and_interpreted_kernels_give_the_same_derivatives(
    p: Parameters, start: State, duration: float, separation: bool
) -> None:
    interpreted, compiled = (
        compute_variation(
            Request(System(p, separation), t_end=duration, start=start, kernel=kernel),
            [*START_SEEDS, Seed((0.5, 0.0, -0.1, 0.0), {"mu": 1.0, "m": -0.3, "F": 2.0})],
        )
        for kernel in KERNELS
    )
    assume(interpreted.switch_times.size == compiled.switch_times.size)
    # Where a motion touches y = 0 and turns back, the time of the switch is known to few digits.
    assume(not separation or abs(compiled.extremes[EXTREMES.index("y_max")]) > 1e-6)
    scale = np.abs(compiled.derivatives).max()
    assert np.abs(interpreted.derivatives - compiled.derivatives).max() < 1e-10 * scale
    assert interpreted.final_rate == pytest.approx(compiled.final_rate, rel=1e-9, abs=1e-9)
    # Equal extremes may be found at different times; compare the others.
    same_extrema = np.abs(interpreted.extreme_times - compiled.extreme_times) < 1e-6
    differences = np.abs(interpreted.extreme_derivatives - compiled.extreme_derivatives)
    assert differences[same_extrema].max(initial=0.0) < 1e-7 * scale
    assert interpreted.switch_times == pytest.approx(compiled.switch_times, abs=1e-9)


@settings(max_examples=25)
@given(moderate_parameters(), states(), st.floats(0.1, 5.0), st.booleans())
@example(Parameters(F=0.0), AT_REST, 5.0, True)
@example(Parameters(F=0.0, mu=0.0), (0.0, 0.0, -1e-9, 0.0), 5.0, True)
def test_volume_shrinks_by_the_divergence_along_every_flow(
    p: Parameters, start: State, duration: float, separation: bool
) -> None:
    derivatives = flow_derivatives(p, start, duration, separation=separation).derivatives
    contraction = np.exp(-(p.c1 + p.c2) / p.m * duration)
    # The determinant of an ill-conditioned matrix loses digits.
    assume(np.linalg.cond(derivatives) < 1e5)
    assert np.linalg.det(derivatives) == pytest.approx(contraction, rel=1e-10)


@settings(max_examples=10)
@given(moderate_parameters(), states(), st.floats(0.2, 3.0), st.floats(0.1, 0.9))
@example(Parameters(k3=0.0, c1=0.0, c2=0.0, F=1.0, mu=0.0), (1.0, 0.0, 0.0, 0.0), 2.5, 0.5)
# Without coupling and preload: the slider, pressed down at the start, lifts off and flies on.
@example(
    Parameters(m=1.0, k1=20.0, k2=20.0, k3=0.0, c2=0.0, F=0.0, k_nl=124.0, mu=0.0),
    (0.0, 0.0, -2.0, 0.0),
    1.0,
    0.5,
)
def test_derivatives_over_two_consecutive_spans_multiply(
    p: Parameters, start: State, duration: float, fraction: float
) -> None:
    complete = flow_derivatives(p, start, duration)
    first = flow_derivatives(p, start, fraction * duration)
    # The kernel treats a tiny start as rest.
    assume(all(abs(z) > 1e3 * START_THRESHOLD or z == 0.0 for z in first.final))
    second = flow_derivatives(p, first.final, duration - fraction * duration)
    # Where motion only touches y = 0, as without damping, rounding decides whether it crosses.
    switches = [*first.switch_times, *(fraction * duration + second.switch_times)]
    assume(len(switches) == complete.switch_times.size)
    assume(np.all(np.diff(switches) > 1e-3))
    scale = np.abs(second.derivatives) @ np.abs(first.derivatives)
    product = second.derivatives @ first.derivatives
    assert (np.abs(product - complete.derivatives) <= 1e-9 * (scale.max() + 1.0)).all()
    # The derivatives map the rate of change at the start to that at the end.
    ax, ay = accelerations(p, start, mode_of(p, start, separation=True))
    _, vx, _, vy = start
    rate = [vx, ax, vy, ay]
    assert complete.derivatives @ rate == pytest.approx(
        complete.final_rate, abs=1e-6 * (scale.max() + 1.0)
    )


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("t_end", [0.01, 60.0])
def test_at_rest_the_flow_is_the_exponential_of_the_jacobian(kernel: Kernel, t_end: float) -> None:
    # A slider at rest allows a single step to the end, too long for deviations, which oscillate.
    p = Parameters(mu=0.3)
    rest = equilibrium(System(p))
    request = Request(
        System(p), t_end=t_end, tol=1e-13, start=(rest.x, 0.0, rest.y, 0.0), kernel=kernel
    )
    expected = expm(np.array(jacobian(p, rest.y, Mode.CONTACT)) * t_end)
    derivatives = compute_variation(request, START_SEEDS).derivatives
    assert np.abs(derivatives - expected).max() < 1e-11 * np.abs(expected).max()


def test_final_state_and_switch_times_are_those_of_a_transient() -> None:
    run = simulate(t_end=7.3, tol=1e-13)
    variation = compute_variation(Request(System(Parameters()), t_end=7.3, tol=1e-13), START_SEEDS)
    assert variation.final == (run.final.x, run.final.vx, run.final.y, run.final.vy)
    assert variation.switch_times.tolist() == run.switch_times.tolist()


@pytest.mark.parametrize("kernel", KERNELS)
def test_derivatives_that_cannot_be_computed_give_the_reason(kernel: Kernel) -> None:
    growing = Parameters(k_nl=0.0, mu=100.0)
    overflowing = Request(System(growing, separation=False), t_end=5000.0, kernel=kernel)
    with pytest.raises(
        ComputationError, match=r"beyond the floating-point range|cannot be computed"
    ):
        compute_variation(overflowing, START_SEEDS)
    # Deviations overflow before the motion does.
    huge_deviations = [Seed((1e300, 0.0, 0.0, 0.0))]
    with pytest.raises(ComputationError, match="derivatives of the motion cannot be computed"):
        compute_variation(
            Request(System(growing, separation=False), t_end=100.0, kernel=kernel), huge_deviations
        )
    with pytest.raises(ComputationError, match="steps"):
        compute_variation(Request(System(Parameters()), max_steps=10, kernel=kernel), START_SEEDS)
    with pytest.raises(Cancelled):
        compute_variation(
            Request(System(Parameters()), kernel=kernel),
            START_SEEDS,
            Progress(lambda share: share < 0.1),
        )


def test_parameters_of_every_size_give_finite_derivatives_or_an_error() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        m, k1, k2, k3 = 10.0 ** rng.uniform(-6.0, 6.0, 4)
        p = Parameters(m=m, k1=k1, k2=k2, k3=k3, k_nl=10.0 ** rng.uniform(-6.0, 15.0))
        request = Request(System(p), t_end=float(3.0 * math.sqrt(m / k2)), max_steps=3000)
        try:
            variation = compute_variation(request, [*START_SEEDS, *PARAMETER_SEEDS])
        except ComputationError:
            continue
        assert np.isfinite(variation.derivatives).all()


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_linear_motion_has_derivatives_however_large_it_is(kernel: Kernel) -> None:
    # The cube of y overflows, but k_nl = 0 makes it irrelevant.
    p = Parameters(k_nl=0.0)
    small, large = (
        compute_variation(
            Request(
                System(p, separation=False), t_end=2.0, start=(0.0, 0.0, y, 0.0), kernel=kernel
            ),
            [*START_SEEDS, Seed(NO_CHANGE, {"mu": 1.0})],
        )
        for y in (-1.0, -1e200)
    )
    assert np.isfinite(large.derivatives).all()
    assert large.derivatives[:, :4] == pytest.approx(small.derivatives[:, :4], rel=1e-10)

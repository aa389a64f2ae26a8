"""Derivatives on a belt of finite speed, against differences of runs and known identities.

`UNIT_MASS` is a mass without coupling with m, k1, k2 and F of 1, mu = 0.5 and mu_s = 1.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import assume, example, given, settings, strategies as st

from fivtui import Parameters, simulate
from fivtui.model import ComputationError, InputError, System, accelerations
from fivtui.model.modes import MODES, Mode, transition_name
from fivtui.model.parameters import ALL_PARAMETERS
from fivtui.model.slider_belt import State, sliding_coefficients
from fivtui.taylor import Deviations, Seed, Segment
from fivtui.transient import START_SEEDS, Request, Variation, compute_variation
from fivtui.transient.derivatives.variation import EXTREMES
from tests.support.strategies import states

from .test_model import belts
from .test_motion import UNIT_MASS

# Parameters, start, horizon in s, and whether separation is considered.
SCENES: Final[dict[str, tuple[Parameters, State, float, bool]]] = {
    "slow belt": (Parameters(v_belt=1.0), (0.1, 0.2, -0.5, 0.1), 8.0, True),
    "static friction": (Parameters(v_belt=1.0, mu_s=0.9), (0.1, 0.2, -0.5, 0.1), 8.0, True),
    "falling friction": (
        Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4),
        (-2.0, -4.0, -1.0, 3.0),
        8.0,
        True,
    ),
    "no separation": (
        Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4),
        (-2.0, -4.0, -1.0, 3.0),
        4.0,
        False,
    ),
    "both ways": (
        Parameters(v_belt=0.3, mu=0.2, k3=0.1, mu_s=0.3),
        (1.5, 5.0, -1.0, 4.0),
        8.0,
        True,
    ),
    "v_s without mu_s": (
        Parameters(v_belt=0.1, mu=0.1, v_s=0.3, F=20.0),
        (2.0, 5.0, -0.3, 4.0),
        8.0,
        True,
    ),
    "at rest": (
        UNIT_MASS.with_values({"v_belt": 0.0, "k_nl": 5.0}),
        (0.0, 0.0, -0.5, 3.0),
        9.0,
        True,
    ),
}


def parameter_names(p: Parameters) -> list[str]:
    return list(p.as_dict())


def compute_derivatives(
    p: Parameters, start: State, t_end: float, *, separation: bool
) -> Variation:
    seeds = [*START_SEEDS, *(Seed((0.0,) * 4, {name: 1.0}) for name in parameter_names(p))]
    request = Request(System(p, separation), t_end=t_end, tol=1e-13, start=start)
    return compute_variation(request, seeds)


def run_changed(
    p: Parameters, start: State, direction: Sequence[float], size: float, **options: Any
) -> tuple[np.ndarray, dict[str, int]]:
    """Final state and extremes of a run with changed start and parameters, and its transitions."""
    state = np.add(start, np.multiply(size, direction[:4])).tolist()
    changes = zip(parameter_names(p), direction[4:], strict=True)
    changed = p.with_values({name: getattr(p, name) + size * change for name, change in changes})
    run = simulate(changed, start=state, tol=1e-13, **options)
    peaks = (run.peak.y_max, run.peak.y_min, run.peak.vx_max)
    return np.array([*run.final[1:], *peaks]), dict(run.events.transitions)


def difference_quotient(
    p: Parameters, start: State, direction: Sequence[float], size: float, **options: Any
) -> tuple[np.ndarray, bool]:
    """The derivative along a direction by differences of fourth order.

    Also returns whether all runs have the same transitions; else there is no derivative.
    """
    runs = [run_changed(p, start, direction, step * size, **options) for step in (-2, -1, 1, 2)]
    far_below, below, above, far_above = (values for values, _ in runs)
    slope = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * size)
    return slope, all(transitions == runs[0][1] for _, transitions in runs)


def derivative_along(variation: Variation, direction: Sequence[float]) -> np.ndarray:
    rows_of_extremes = [EXTREMES.index(name) for name in ("y_max", "y_min", "vx_max")]
    rows = np.concatenate([variation.derivatives, variation.extreme_derivatives[rows_of_extremes]])
    change: np.ndarray = rows @ np.array(direction)
    return change


def random_directions(p: Parameters, count: int) -> list[list[float]]:
    # Parameters that are zero (belt at rest, mass without coupling) are not varied.
    rng = np.random.default_rng(4)
    free = [getattr(p, name) > 0.0 for name in parameter_names(p)]
    return [
        (rng.normal(size=4 + len(free)) * np.array([True] * 4 + free)).tolist()
        for _ in range(count)
    ]


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_are_differences_of_runs(name: str) -> None:
    p, start, t_end, separation = SCENES[name]
    variation = compute_derivatives(p, start, t_end, separation=separation)
    for direction in random_directions(p, 1):
        if name == "at rest":
            # A moving slider on a belt at rest would change the sequence of modes.
            direction[:2] = 0.0, 0.0
        expected, same_transitions = difference_quotient(
            p, start, direction, 1e-6, t_end=t_end, separation=separation
        )
        assert same_transitions
        assert (
            np.abs(derivative_along(variation, direction) - expected).max()
            < 3e-8 * np.abs(expected).max()
        )


def test_the_scenes_have_all_transitions_of_the_table() -> None:
    transitions = set()
    for p, start, t_end, separation in SCENES.values():
        run = simulate(p, start=start, t_end=t_end, separation=separation)
        transitions |= set(run.events.transitions)
    rows = [(mode, end) for mode, row in MODES.items() for end in row.ends]
    pairs = [(mode, successor) for mode, end in rows for successor in end.next_modes]
    # CONTACT is the mode on a belt that is always faster, without `v_belt`.
    assert transitions == {transition_name(*pair) for pair in pairs if Mode.CONTACT not in pair}


# At the end of the stick rounding makes the slider faster than the belt.
@example(
    Parameters(
        m=7.0,
        k1=20.0,
        k2=20.0,
        k3=0.0,
        c1=0.0,
        c2=0.0,
        F=110.0,
        k_nl=9.0,
        mu=1.0,
        v_belt=1.5,
        mu_s=1.5,
    ),
    (0.0, 0.0, 1.0, 2.0),
    2.0,
    False,
)
@settings(max_examples=5)
@given(belts(), states(), st.floats(0.1, 2.0), st.booleans())
def test_derivatives_of_random_scenes_are_differences_of_runs(
    p: Parameters, start: State, duration: float, separation: bool
) -> None:
    # Central differences need values inside the ranges of the parameters: above 0, and mu_s above
    # mu. Without mu_s, `mu_static` is mu.
    inside = {name: max(value, 0.01) for name, value in p.as_dict().items()}
    p = p.with_values({**inside, "mu_s": max(p.mu_static, inside["mu"] + 0.01)})
    (direction,) = random_directions(p, 1)
    options: dict[str, Any] = {"t_end": duration, "separation": separation}
    coarse, same_when_coarse = difference_quotient(p, start, direction, 2e-6, **options)
    fine, same_when_fine = difference_quotient(p, start, direction, 1e-6, **options)
    scale = np.abs(fine).max()
    assume(same_when_coarse and same_when_fine and np.abs(coarse - fine).max() < 1e-6 * scale)
    derivative = derivative_along(
        compute_derivatives(p, start, duration, separation=separation), direction
    )
    assert np.abs(derivative - fine).max() < 3e-6 * scale


def test_the_friction_law_has_a_derivative_by_mu_s_where_mu_s_is_equal_to_mu() -> None:
    p = Parameters(v_belt=0.5, mu_s=0.7, v_s=0.4)
    runs = [
        compute_derivatives(
            p.with_values({"mu_s": mu}), (-2.0, -4.0, -1.0, 3.0), 1.5, separation=True
        )
        for mu in (0.7, 0.7 + 1e-6)
    ]
    column = 4 + parameter_names(p).index("mu_s")
    below, above = (end.derivatives[:, column] for end in runs)
    assert np.abs(below - above).max() < 1e-4 * np.abs(below).max()
    assert np.abs(np.subtract(runs[1].final, runs[0].final) / 1e-6 - below).max() < 1e-4


def test_a_stick_reduces_the_rank_of_the_derivatives_exactly() -> None:
    p, start = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4), (0.1, 0.2, -0.5, 0.1)
    run = simulate(p, start=start, t_end=8.0)
    begin, end = run.stick_intervals[1]
    inside = compute_derivatives(p, start, 0.5 * (begin + end), separation=True)
    assert inside.derivatives[1, :4].tolist() == [0.0] * 4
    names = parameter_names(p)
    expected = [float(name == "v_belt") for name in names]
    assert inside.derivatives[1, 4:].tolist() == expected
    assert inside.final[1] == 1.0
    assert inside.final_rate[1] == 0.0
    after = compute_derivatives(p, start, 8.0, separation=True).derivatives[:, :4]
    greatest, _, third, least = np.linalg.svd(after, compute_uv=False)
    assert third > 1e-14 * greatest
    assert least < 1e-14 * greatest


def test_a_reversal_of_slip_multiplies_the_volume_of_states_by_the_ratio_of_accelerations() -> None:
    # The volume is the determinant of the derivatives by the start. Friction is constant and too
    # weak for a stick: between reversals only the dampers change the volume.
    p = Parameters(v_belt=0.5, mu=0.05, F=10.0, k_nl=0.0)
    assert sliding_coefficients(p, -0.4, Mode.FORWARD) == (p.mu, p.c1)
    start, t_end = (3.0, 0.0, -0.4, 0.0), 3.0
    run = simulate(p, start=start, t_end=t_end, separation=False, tol=1e-13, samples="dense")
    assert set(run.events.transitions) == {"forward-backward", "backward-forward"}
    assert run.solution is not None
    volume = np.exp(-(p.c1 + p.c2) / p.m * t_end)
    for change in run.mode_changes:
        motion = run.solution([change.t])
        state = (float(motion.x[0]), 0.5, float(motion.y[0]), float(motion.vy[0]))
        volume *= accelerations(p, state, change.then)[0] / accelerations(p, state, change.first)[0]
    flow = compute_derivatives(p, start, t_end, separation=False).derivatives[:, :4]
    assert np.linalg.det(flow) == pytest.approx(volume, rel=1e-10)


def test_a_motion_that_only_touches_a_guard_has_no_derivatives() -> None:
    # The spring balances friction where the slider reaches the speed of the belt.
    state: State = (0.5, 0.2, -1.0, 0.0)
    segment = Segment(
        Mode.FORWARD,
        start=0.0,
        start_remainder=0.0,
        duration=1e-9,
        end=1e-9,
        # Coefficients in the fraction of the duration: x grows by 0.2 m/s.
        x=(0.5, 2e-10, 0.0, 0.0),
        y=(-1.0, 0.0, 0.0, 0.0),
        final=state,
        next_mode=Mode.BACKWARD,
    )
    with pytest.raises(ComputationError, match="touches v_r = 0 without crossing it"):
        Deviations(UNIT_MASS, START_SEEDS).advance(segment)


def test_sensitivities_of_simulate_are_those_of_the_run() -> None:
    p = Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4)
    names = ["mu", "mu_s", "v_belt", "v_s", "F"]
    run = simulate(p, t_end=6.0, tol=1e-13, sensitivities=names)
    assert run.sensitivities is not None
    for name in names:
        sensitivity = run.sensitivities[name]
        runs = []
        for size in (-1e-6, 1e-6):
            changed = p.with_values({name: getattr(p, name) + size})
            runs.append(simulate(changed, t_end=6.0, tol=1e-13))
        low, high = runs
        expected = [b - a for a, b in zip(low.final[1:], high.final[1:], strict=True)]
        assert np.array(sensitivity.final) == pytest.approx(
            np.array(expected) / 2e-6, rel=1e-5, abs=1e-6
        )
        steps = (high.peak.y_max - low.peak.y_max, high.contact_force.max - low.contact_force.max)
        assert (sensitivity.peak.y_max, sensitivity.contact_force.max) == pytest.approx(
            np.array(steps) / 2e-6, rel=1e-5, abs=1e-6
        )


def test_derivatives_by_parameters_without_value_are_refused() -> None:
    for values, name, missing in (
        ({"v_belt": 1.0}, "v_s", "v_s"),
        ({"v_belt": 1.0}, "mu_s", "mu_s"),
        ({"v_s": 0.4}, "v_s", "v_belt"),
        ({}, "v_belt", "v_belt"),
    ):
        p = Parameters().with_values(values)
        with pytest.raises(
            InputError, match=f"^{missing} = none: must have a value for .* {name}$"
        ):
            simulate(p, t_end=1.0, sensitivities=[name])
    # Without values the belt's parameters are not among the names.
    assert set(parameter_names(Parameters())) < set(ALL_PARAMETERS)

"""Inputs that change within an integrator step, compared with derivatives written independently."""

from itertools import pairwise
from typing import Any

import pytest

from fivtui.model.parameters import Parameters
from fmu_src.slave.motion import SliderBeltMotion
from tests.support.fmu_driver import Driver

STATES = ["x", "vx", "y", "vy"]
OUTPUTS = ["P", "friction_slider", "friction_belt", "mode", "switching", "ax", "ay", "F", "mu"]
# Not the base set: all values differ, so that swapped parameters are noticed.
VALUES = {"m": 3.0, "k1": 90.0, "k2": 40.0, "k3": 50.0, "c1": 0.7, "c2": 0.4, "k_nl": 120.0}
INPUT_PAIRS = [(100.0, 0.9), (30.0, 0.2), (-40.0, 1.5), (150.0, 0.0)]
H = 2e-4


def contact_force(y: float, *, contact: bool) -> float:
    """Contact force P, N, at a height y, m."""
    return -VALUES["k2"] * y - VALUES["k_nl"] * y**3 if contact else 0.0


def rates(state: list[float], F: float, mu: float, *, contact: bool) -> list[float]:
    """ẋ, ẍ, ẏ, ÿ of the equations of motion."""
    x, vx, y, vy = state
    m, k1, _, k3, c1, c2, _ = VALUES.values()
    # The coupling stiffness of the spring k3, which is at 45°.
    h = k3 / 2.0
    P = contact_force(y, contact=contact)
    ax = (mu * P - c1 * vx - (k1 + h) * x + h * y) / m
    ay = (P - F - c2 * vy - h * y + h * x) / m
    return [vx, ax, vy, ay]


@pytest.mark.parametrize("separation", [True, False])
def test_after_a_change_of_inputs_the_motion_has_the_derivatives_of_the_new_ones(
    driver: Driver, separation: bool
) -> None:
    start = {"start_static": False, "separation": separation, "x_start": 0.5, "vx_start": -1.0}
    calls: list[Any] = [("a", "begin", {**VALUES, **start, "y_start": -0.9, "vy_start": 0.3})]
    change_times = [0.0, 0.31, 0.87, 1.62, 2.2, 2.9, 3.7, 4.4]
    input_pairs = INPUT_PAIRS * 2
    for (t, next_time), (F, mu) in zip(pairwise([*change_times, 5.0]), input_pairs, strict=True):
        calls += [("a", "get", STATES), ("a", "set", {"F": F, "mu": mu})]
        calls += [("a", "get", [*STATES, *OUTPUTS])]
        calls += [("a", "step", t, H), ("a", "get", STATES)]
        calls += [("a", "step", t + H, H), ("a", "get", STATES)]
        calls += [("a", "step", t + 2 * H, next_time - (t + 2 * H))]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    # Four reads at each change of the inputs: before, after, and after each of two short steps.
    reads = [answer.value for answer in answers if isinstance(answer.value, list)]
    modes = set()
    for t, (F, mu), before, after, middle, final in zip(
        change_times,
        input_pairs,
        *(reads[first::4] for first in range(4)),
        strict=True,
    ):
        read = dict(zip([*STATES, *OUTPUTS], after, strict=True))
        contact = read["y"] < 0.0 or not separation
        modes.add(read["mode"])
        # The state does not jump; quantities that depend on inputs change at once.
        assert [read[name] for name in STATES] == before
        assert (read["F"], read["mu"]) == (F, mu)
        P = contact_force(read["y"], contact=contact)
        assert read["P"] == pytest.approx(P, rel=1e-12, abs=1e-12)
        assert read["friction_slider"] == pytest.approx(mu * P, rel=1e-12, abs=1e-12)
        assert read["friction_belt"] == pytest.approx(-mu * P, rel=1e-12, abs=1e-12)
        assert (read["mode"], read["switching"]) == (float(contact), read["y"])
        derivative = rates(before, F, mu, contact=contact)
        assert [read["ax"], read["ay"]] == pytest.approx(derivative[1::2], rel=1e-12, abs=1e-11)
        # The slope in the middle of two short steps agrees with the equations of motion.
        slope = [(b - a) / (2.0 * H) for a, b in zip(before, final, strict=True)]
        exact = rates(middle, F, mu, contact=contact)
        assert slope == pytest.approx(exact, rel=2e-4, abs=2e-3), t
    assert modes == ({0.0, 1.0} if separation else {1.0})


def test_the_motion_continues_within_the_step_under_changed_inputs() -> None:
    p, start = Parameters(**VALUES), (0.5, -1.0, -0.9, 0.3)
    motion = SliderBeltMotion(p, start, t=0.0, separation=True, tol=1e-9)
    motion.move_to(0.01, p.with_values({"F": 100.0, "mu": 0.9}))
    motion.move_to(0.02, p.with_values({"F": 30.0, "mu": 0.2}))
    at = motion.current
    assert (at.p.F, at.p.mu) == (30.0, 0.2)
    motion.move_to(0.03, p.with_values({"F": 30.0, "mu": 0.2}))
    # The Taylor polynomial of the motion continues: the inputs are unchanged.
    assert motion.current.segment is at.segment

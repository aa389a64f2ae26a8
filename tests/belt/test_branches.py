"""Branches of limit cycles on a belt of finite speed, against closed forms.

A branch has a corner where the order of modes (stick, slip forward or backward) of its cycles
changes. `UNIT_MASS` is a mass without coupling with m, k1, k2 and F of 1, mu = 0.5 and mu_s = 1.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from fivtui import Parameters, branch, continuation
from fivtui.cli import run
from fivtui.equilibrium import growth_rate
from fivtui.model import InputError, System
from fivtui.orbits import End, EventKind
from fivtui.orbits.curves.arclength import PARAMETER, PERIOD
from fivtui.orbits.curves.branch_curve import ParameterLine, mode_pattern
from fivtui.orbits.curves.cycle_branches import parameter_range
from fivtui.orbits.curves.hopf import hopf_point, hopf_values
from fivtui.orbits.curves.origins import cycle_near

from .test_motion import CYCLE_PERIOD, UNIT_MASS

# With a damper of the vertical motion its cycle attracts.
DAMPED = UNIT_MASS.with_values({"c2": 0.1})
# Sliding loses stability as the belt slows down; cycles near this Hopf point are unstable.
FALLING = Parameters(v_belt=0.4, mu=0.3, mu_s=0.5, v_s=0.4, c1=10.0)
# A state in the middle of a stick: x grows at the belt's 0.2 m/s from 0 to mu_s P/k1 = 1 m.
MID_STICK = (0.5, 0.2, -1.0, 0.0)


def cycle_period(speed: float, drop: float) -> float:
    """Period of a stick-slip cycle of `UNIT_MASS` on a belt of this speed; drop is mu_s - mu."""
    return 2.0 * drop / speed + 2.0 * (math.pi - math.atan(drop / speed))


@pytest.mark.parametrize("name", ["v_belt", "mu", "mu_s"])
def test_the_period_of_a_mass_on_a_belt_has_the_derivatives_of_the_closed_form(name: str) -> None:
    value = DAMPED.as_dict()[name]
    line = ParameterLine(System(DAMPED), name, (0.5 * value, 2.0 * value))
    curve, orbit = cycle_near(line, (MID_STICK, CYCLE_PERIOD))
    assert orbit is not None
    scales = curve.scales
    assert orbit.unknowns[PERIOD] * scales[PERIOD] == pytest.approx(CYCLE_PERIOD, rel=1e-12)
    slope = orbit.tangent[PERIOD] / orbit.tangent[PARAMETER] * scales[PERIOD] / scales[PARAMETER]
    # Derivatives of `cycle_period` by its two arguments.
    speed, drop = 0.2, 0.5
    by_drop = 2.0 / speed - 2.0 * speed / (speed**2 + drop**2)
    by_speed = -2.0 * drop / speed**2 + 2.0 * drop / (speed**2 + drop**2)
    expected = {"v_belt": by_speed, "mu": -by_drop, "mu_s": by_drop}[name]
    assert slope == pytest.approx(expected, rel=1e-9)
    # One stick in a period, and the part of it before the start of the orbit.
    pattern = mode_pattern(orbit)
    assert pattern.sticks == 1.0
    assert 0.0 < pattern.start_in_stick < 1.0


def branch_command(p: Parameters) -> list[str]:
    settings = [f"--set={name}={value}" for name, value in p.as_dict().items()]
    return ["branch", *settings, "--vary", "v_belt=0.19:0.21"]


def test_a_branch_of_stick_slip_cycles_has_the_period_in_closed_form_and_a_multiplier_0(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    curve = branch(DAMPED, "v_belt", low=0.15, high=0.25, origin="cycle")
    assert curve.ends == (End.BOUND, End.BOUND)
    assert not curve.events
    for point in curve.points:
        assert point.period == pytest.approx(cycle_period(point.value, 0.5), rel=1e-10)
        assert point.stable
        assert point.multipliers[2] == 0.0
        vertical_decay = math.exp(-DAMPED.c2 / (2.0 * DAMPED.m) * point.period)
        assert abs(point.multipliers[0]) == pytest.approx(vertical_decay, rel=1e-8)
    path = tmp_path / "cycles.csv"
    command = branch_command(DAMPED)
    assert run([*command, "--from", "cycle", "--out", str(path), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["parameter"], data["unit"]) == ("v_belt", "m/s")
    assert data["points"][0]["multipliers"][2] == [0.0, 0.0]
    assert run([*command, "--from", str(path), "--json"]) == 0
    points_from_file = json.loads(capsys.readouterr().out)["points"]
    assert [round(point["period"], 9) for point in points_from_file] == pytest.approx(
        [round(cycle_period(point["value"], 0.5), 9) for point in points_from_file], abs=1e-9
    )
    command_of_less_friction = branch_command(DAMPED.with_values({"mu_s": 0.9}))
    assert run([*command_of_less_friction, "--from", str(path)]) == 2
    assert "mu_s = 0.9: must be 1, as in " in capsys.readouterr().err


def test_small_cycles_have_the_amplitude_of_the_normal_form() -> None:
    value, _ = hopf_values(System(FALLING), "v_belt", 0.05, 2.0)
    for hopf_value in hopf_values(System(FALLING), "c1", 5.0, 20.0):
        assert abs(growth_rate(System(FALLING.with_values({"c1": hopf_value})))) < 1e-9
    hopf_set = FALLING.with_values({"v_belt": value})
    assert abs(growth_rate(System(hopf_set))) < 1e-9
    hopf = hopf_point(System(hopf_set), "v_belt")
    assert hopf.direction == "subcritical"
    curve = branch(FALLING, "v_belt", low=0.4428, high=0.4432)
    assert [event.direction for event in curve.events] == ["subcritical"]
    for point in curve.points:
        assert not point.stable
        growth = growth_rate(System(FALLING.with_values({"v_belt": point.value})))
        size = 2.0 * math.sqrt(-growth / hopf.lyapunov)
        assert point.half_range == pytest.approx(size, rel=0.02)
        assert point.period == pytest.approx(2.0 * math.pi / hopf.omega, rel=1e-3)


@pytest.mark.whole
def test_a_cycle_that_reaches_the_belt_speed_only_off_the_belt_does_not_depend_on_it() -> None:
    curve = branch(Parameters(v_belt=5.4), "v_belt", low=5.3, high=5.7, origin="cycle")
    (event,) = curve.events
    assert event.kind is EventKind.REVERSE_SLIP
    fastest = curve.points[-1]
    assert fastest.value == 5.7
    # The period of the cycle without belt speed, as in the paper.
    assert fastest.period == pytest.approx(1.3264574885, rel=1e-10)
    assert event.period == pytest.approx(fastest.period, rel=1e-8)
    assert curve.points[0].period > fastest.period + 1e-6


@pytest.mark.whole
def test_a_branch_turns_back_where_its_cycles_begin_to_stick() -> None:
    curve = branch(FALLING, "v_belt", low=0.05, high=2.0)
    kinds = [event.kind for event in curve.events]
    assert kinds[:2] == [EventKind.HOPF, EventKind.STICK]
    corner = curve.events[1]
    assert corner.value == pytest.approx(0.5215068632, rel=1e-8)
    assert corner.value == max(point.value for point in curve.points)
    corner_index = next(
        index for index, point in enumerate(curve.points) if point.value == corner.value
    )
    before, after = curve.points[:corner_index], curve.points[corner_index + 1 :]
    assert all(point.multipliers[2] != 0.0 for point in before)
    assert all(point.multipliers[2] == 0.0 for point in after)
    # The branch contains the stable cycle that transients reach.
    cycle = min(after, key=lambda point: abs(point.value - 0.4))
    assert cycle.stable
    assert cycle.half_range == pytest.approx(0.0387832, rel=0.03)
    assert len(kinds) == len(set(zip(kinds, (e.value for e in curve.events), strict=True)))


@pytest.mark.whole
def test_where_motion_jumps_a_branch_ends_with_that_reason() -> None:
    # Static friction exceeds sliding friction: a slider that just reaches the belt speed is held at
    # once, for a finite time. So the motion jumps, and no cycle near it continues the branch.
    p = FALLING.with_values({"v_s": None, "mu": 0.44, "c1": 0.32, "v_belt": 1.0})
    curve = branch(p, "mu", low=0.42, high=0.45)
    assert curve.points[-1].value == pytest.approx(0.43315931, rel=1e-7)
    assert curve.ends[0] is End.EQUILIBRIUM
    assert curve.ends[1] is End.JUMPS
    assert curve.ends[1] in str(curve)


def test_the_order_of_modes_does_not_depend_on_where_a_period_begins() -> None:
    patterns = []
    for share in (0.0, 0.3, 0.6, 0.9):
        line = ParameterLine(System(DAMPED), "v_belt", (0.1, 0.4))
        curve, orbit = cycle_near(line, (MID_STICK, CYCLE_PERIOD))
        assert orbit is not None
        restarted = curve.orbits.restart_later(orbit, share) if share else orbit
        assert restarted is not None
        patterns.append(curve.pattern(restarted))
        values = np.sort(np.abs(restarted.multipliers))
        assert values == pytest.approx(np.sort(np.abs(orbit.multipliers)), abs=1e-9)
    assert len(set(patterns)) == 1


def test_doubled_branches_and_parameters_without_value_are_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(
        InputError,
        match=r"to follow an attracting cycle of twice the period begin at it \(--from cycle\)",
    ):
        branch(DAMPED, "v_belt", origin="cycle", doubled=True)
    assert run(["branch", "--set", "v_belt=1", "--vary", "v_s"]) == 2
    assert "v_s = none: must have a value to vary v_s" in capsys.readouterr().err


def test_friction_is_followed_up_to_its_static_value() -> None:
    p = Parameters(v_belt=1.0, mu_s=0.8)
    assert parameter_range(p, "mu", None, None)[1] == 0.8
    assert parameter_range(p, "mu_s", None, 2.0) == (0.7, 2.0)
    with pytest.raises(InputError, match=r"^mu: 0\.5 to 1\.2: must be at most mu_s = 0\.8$"):
        branch(p, "mu", low=0.5, high=1.2, origin="cycle")
    with pytest.raises(InputError, match=r"^mu_s: 0\.5 to 1: must be at least mu = 0\.7$"):
        branch(p, "mu_s", low=0.5, high=1.0, origin="cycle")
    with pytest.raises(InputError, match=r"^mu_s = 0\.8: must be none, or at least mu = 0\.9$"):
        continuation(p, "mu", [0.3, 0.9])

"""RK4 across the switches, and errors against CPU time, on a belt of finite speed."""

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model import State
from fivtui.scene import Scene
from fivtui.tradeoffs import measure
from fivtui.tradeoffs.measure import measure_tradeoff
from fivtui.transient import Start, Transient

BELT = Parameters(v_belt=1.0)
HOLDING = Parameters(v_belt=0.5, mu_s=0.9, v_s=0.4)
HELD: State = (0.0, 0.5, -1.0, 0.0)


def across(p: Parameters, step: float, *, start: Start = "static") -> Transient:
    return simulate(p, t_end=1.5, method="rk4-across", step=step, start=start)


def test_rk4_across_knows_no_stick_and_converges_by_its_first_order_at_most() -> None:
    known = simulate(HOLDING, t_end=1.5, start=HELD)
    assert known.events.sticks > 0
    steps = [4e-3, 2e-3, 1e-3, 5e-4]
    runs = [across(HOLDING, step, start=HELD) for step in steps]
    errors = [np.abs(np.subtract(run.final, known.final)).max() for run in runs]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.5 < order < 1.6
    assert {run.events.sticks for run in runs} == {0}
    assert all(run.events.transitions["forward-backward"] > 5 for run in runs)


def test_rk4_across_has_no_friction_at_the_speed_of_the_belt() -> None:
    # A slider at rest on a belt at rest: any other sign would move it.
    rest = Parameters(v_belt=0.0)
    known = simulate(rest, t_end=1.5)
    assert across(rest, 2e-3).final == pytest.approx(known.final, abs=1e-6)
    assert across(Parameters(v_belt=40.0), 2e-3).final == across(Parameters(), 2e-3).final


def test_the_trade_shows_what_every_method_loses_on_a_belt_of_finite_speed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(measure, "QUICK_S", 1.0)
    found = measure_tradeoff(Scene("belt", "", BELT, t_end=4.0))
    assert found.floor.of("final") < 1e-10
    least: dict[str, float] = {}
    for row in found.rows:
        if row.error is not None:
            method, error = row.setting.method, row.error.of("final")
            least[method] = min(error, least.get(method, np.inf))
    assert least["taylor"] < 1e-10
    assert least["fmu"] < 1e-10
    assert least["rk4"] < 0.1
    assert 1e-4 < least["rk4-across"] < 10.0
    fmu = [row for row in found.rows if row.setting.method == "fmu" and row.error is not None]
    assert fmu[-1].error is not None
    assert fmu[-1].error.of("events") < 1e-10
    assert "belt of finite speed" in [feature.name for feature in found.features]

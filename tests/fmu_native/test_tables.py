"""Transients through the native FMU with tables: inputs follow them by values and slopes."""

from pathlib import Path

import pytest

from fivtui import Parameters, find_scene, simulate
from fivtui.model import Mode
from fivtui.transient import Transient
from tests.support.fmu_instance import FmuInstance

Tables = dict[str, list[tuple[float, float]]]
RAMPS: Tables = {
    "F": [(0.0, 20.0), (1.0, 100.0), (4.0, 60.0)],
    "mu": [(1.0, 0.5), (3.3, 0.9)],
}


def assert_same(run: Transient, expected: Transient) -> None:
    assert list(run.final) == pytest.approx(list(expected.final), abs=1e-9)
    assert run.switch_times == pytest.approx(expected.switch_times, abs=1e-9)
    assert run.events.transitions == expected.events.transitions
    assert [change.t for change in run.mode_changes] == pytest.approx(
        [change.t for change in expected.mode_changes], abs=1e-9
    )
    # Extremes of x, y and ẋ over the run.
    assert run.peak == pytest.approx(expected.peak, abs=1e-6)


def run_both_methods(p: Parameters, tables: Tables, t_end: float) -> tuple[Transient, Transient]:
    actual, expected = (
        simulate(p, t_end=t_end, over_time=tables, method=method, samples=9)
        for method in ("fmu-native", "taylor")
    )
    columns = actual.to_columns()
    for name, values in expected.to_columns().items():
        assert columns[name] == pytest.approx(values, abs=1e-8)
    return actual, expected


def test_preload_and_friction_follow_tables() -> None:
    run, expected = run_both_methods(Parameters(), RAMPS, 6.0)
    assert expected.events.separations > 0
    assert_same(run, expected)


def test_the_belt_follows_its_table_to_rest() -> None:
    tables = {"F": RAMPS["F"], "v_belt": [(0.0, 2.0), (5.0, 0.0)]}
    for belt in ({"mu_s": 0.9, "v_s": 0.4}, {"mu_s": 0.8}):
        # The table replaces the constant speed of 1 m/s.
        run, expected = run_both_methods(Parameters(v_belt=1.0, **belt), tables, 8.0)
        assert expected.events.sticks > 1
        assert_same(run, expected)


def test_a_belt_comes_to_rest_by_ramps_that_miss_zero_by_rounding(folder: Path) -> None:
    t = 4.999428538771778
    speed = 2.0 - 0.4 * t
    final_speed = speed - 0.4 * (5.0 - t)
    # Negative by rounding.
    assert final_speed < -1e-17
    with FmuInstance(folder).begin(finite_belt=True, v_belt=speed) as instance:
        instance.set_slopes(v_belt=-0.4)
        instance.step(5.0 - t)
        assert instance.get("v_belt") == pytest.approx([0.0], abs=1e-15)
        # The belt is at rest, and so is the slider that sticks to it.
        instance.step(20.0)
        assert instance.get("mode", "vx") == [Mode.STICK, 0.0]


def test_inputs_that_jump_change_the_mode_at_once() -> None:
    p = Parameters(m=1.0, k1=0.1, k2=1.0, k3=0.0, c1=0.0, c2=0.0, F=1.0, k_nl=0.0, mu=0.5, mu_s=1.0)
    for second_speed in (0.2, 3.0):
        rows = [(0.0, 1.0), (1.0, 1.0), (1.0, second_speed)]
        tables: Tables = {"v_belt": rows}
        actual, expected = (
            simulate(p, t_end=1.5, start=(0.0, 1.0, -1.0, 0.0), over_time=tables, method=method)
            for method in ("fmu-native", "taylor")
        )
        assert expected.mode_changes[0].t == 1.0
        assert_same(actual, expected)


def test_a_preset_with_tables_runs_through_the_fmu() -> None:
    # A preset is a named scene: parameters, and tables of those that change over time.
    preset = find_scene("brake-stop")
    tables = {name: table.rows() for name, table in preset.over_time}
    actual, expected = (
        simulate(preset.parameters, t_end=12.0, over_time=tables, method=method, step=step)
        for method, step in (("fmu-native", 0.1), ("taylor", None))
    )
    assert_same(actual, expected)
    # Times of squeal, of groan, and of the final stick, while the belt slows down.
    assert actual.stop == pytest.approx(expected.stop)

"""A native FMU whose inputs follow tables gives the answer of the native solver."""

from pathlib import Path

import pytest

from fivtui import Parameters, simulate
from fivtui.model import course_of
from tests.support.fmu_instance import FmuInstance

TABLES: dict[str, list[tuple[float, float]]] = {
    "F": [(0, 20), (4, 100), (8, 100), (12, 60)],
    "mu": [(0, 0.2), (4, 0.2), (8, 0.8)],
}


@pytest.mark.parametrize("step", [1.0, 0.25])
def test_inputs_over_time_agree_with_tables_of_the_native_solver(folder: Path, step: float) -> None:
    course = course_of(Parameters(), TABLES)
    p, _ = course.after(0.0)
    with FmuInstance(folder).begin(F=p.F, mu=p.mu) as instance:
        while instance.t < 15.0:
            p, rates = course.after(instance.t)
            instance.set(F=p.F, mu=p.mu)
            instance.slope(F=rates.F, mu=rates.mu)
            instance.step(step)
        found = instance.get("x", "vx", "y", "vy", "separations")
    run = simulate(t_end=15.0, over_time=TABLES)
    assert run.events.separations > 0
    assert found == pytest.approx([*run.final[1:], run.events.separations], abs=1e-10)

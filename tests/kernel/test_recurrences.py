"""The kernel's expansions equal those of a plain recurrence from the model's equations.

A course has the parameters as functions of time.
"""

from collections.abc import Mapping

import numpy as np
import pytest

from fivtui import Parameters, simulate
from fivtui.model import MODES, Mode, State, build_course
from fivtui.model.over_time import Rows
from fivtui.taylor.recurrence import Terms, motion_function
from fivtui.transient.request import KernelChoice

START: State = (0.4, 4.0, -0.3, -6.0)
BELT_VALUES = {"v_belt": 1.0, "mu": 0.5, "mu_s": 0.9}
# Friction by a law: it falls with the sliding speed, over v_s.
LAW_VALUES = {**BELT_VALUES, "v_s": 0.4}
TABLES: Mapping[str, Rows] = {"F": [(0.0, 60.0), (9.0, 90.0)], "mu": [(0.0, 0.7), (9.0, 0.4)]}
BELT_TABLES: Mapping[str, Rows] = {**TABLES, "v_belt": [(0.0, 1.5), (9.0, 0.5)]}
# Parameters, tables, and the modes that occur.
RUNS: Mapping[str, tuple[Mapping[str, float], Mapping[str, Rows], set[Mode]]] = {
    "cubic": ({}, {}, {Mode.CONTACT, Mode.SEPARATED}),
    "linear": ({"k_nl": 0.0, "mu": 1.2}, {}, {Mode.CONTACT, Mode.SEPARATED}),
    "tables": ({}, TABLES, {Mode.CONTACT, Mode.SEPARATED}),
    "belt": (BELT_VALUES, {}, {Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK}),
    "law": (LAW_VALUES, {}, {Mode.SEPARATED, Mode.FORWARD, Mode.BACKWARD, Mode.STICK}),
    "law, linear": ({**LAW_VALUES, "k_nl": 0.0}, {}, {Mode.SEPARATED, Mode.FORWARD, Mode.STICK}),
    "belt and tables": (BELT_VALUES, BELT_TABLES, {Mode.SEPARATED, Mode.FORWARD, Mode.STICK}),
    "law and tables": (LAW_VALUES, BELT_TABLES, {Mode.SEPARATED, Mode.FORWARD, Mode.STICK}),
}


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("kernel", ["compiled", "interpreted"])
def test_the_coefficients_of_every_segment_follow_from_the_equations(
    name: str, kernel: KernelChoice
) -> None:
    values, tables, modes = RUNS[name]
    p = Parameters().with_values(values)
    run = simulate(p, t_end=9.0, start=START, samples="dense", kernel=kernel, over_time=tables)
    motion = run.solution
    assert motion is not None
    course = build_course(p, tables)
    for column, number in enumerate(motion._mode):
        mode, start, duration = Mode(number), motion._start[column], motion._duration[column]
        parameters, rates = course.after(start)
        terms = Terms(
            by_law=p.v_s is not None and MODES[mode].slips,
            finite_belt=p.v_belt is not None,
            over_time=bool(tables),
        )
        # Coefficients of powers of time/duration: order + 2 of them, from 0 on.
        x, y = motion._x[:, column], motion._y[:, column]
        order = len(x) - 2
        state = (x[0], x[1] / duration, y[0], y[1] / duration)
        expected = motion_function(terms, mode)(parameters, rates, state, order)
        powers = duration ** np.arange(len(x))
        for coefficients, from_equations in zip((x, y), expected, strict=True):
            # At the onset of sliding a run sets ẍ to the acceleration of the belt, which the
            # equations give only up to rounding. So the tolerance is absolute.
            tolerance = 1e-12 * (1.0 + np.abs(coefficients).max())
            assert coefficients == pytest.approx(from_equations * powers, rel=0.0, abs=tolerance)
    assert set(motion._mode.tolist()) >= modes

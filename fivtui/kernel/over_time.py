"""Parameters over time as a table for the kernel."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Course, load


@dataclass(frozen=True, slots=True)
class CourseTable:
    """Rows of time, values and slopes of F, μ, μ_s and v_belt, and v_belt before the next row."""

    rows: NDArray[np.float64]
    greatest_load: float


def course_table(course: Course, t_end: float) -> CourseTable:
    """The table of a course up to a horizon, s."""
    p, t, rows = course.fixed, 0.0, []
    while t <= t_end:
        values = {name: table.after(t) for name, table in course.tables.items()}
        mu = values.get("mu", (p.mu, 0.0))
        mu_static = mu if p.mu_s is None else (p.mu_s, 0.0)
        speed = values.get("v_belt", (p.v_belt or 0.0, 0.0))
        next_time = course.next_row_time(t)
        speed_before = course.speed_before(next_time)
        rows.append((t, *values.get("F", (p.F, 0.0)), *mu, *mu_static, *speed, speed_before))
        t = next_time
    parameters_at_greatest_load = p.with_values({"F": course.greatest_load})
    return CourseTable(np.array(rows), abs(load(parameters_at_greatest_load)))

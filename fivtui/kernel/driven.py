"""Parameters over time as the kernel reads them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Course, load


@dataclass(frozen=True, slots=True)
class Legs:
    """F, μ, μ_s and v_belt over time, linear between rows."""

    rows: NDArray[np.float64]
    greatest_load: float


def legs_of(course: Course, t_end: float) -> Legs:
    """The legs of a course up to a horizon, s."""
    p, t, rows = course.fixed, 0.0, []
    while t <= t_end:
        rows_after = {name: table.after(t) for name, table in course.tables.items()}
        mu = rows_after.get("mu", (p.mu, 0.0))
        grip = mu if p.mu_s is None else (p.mu_s, 0.0)
        speed = rows_after.get("v_belt", (p.v_belt or 0.0, 0.0))
        after = course.next_break(t)
        speed_before = course.speed_before(after)
        rows.append((t, *rows_after.get("F", (p.F, 0.0)), *mu, *grip, *speed, speed_before))
        t = after
    greatest = p.with_values({"F": course.greatest_load})
    return Legs(np.array(rows), abs(load(greatest)))

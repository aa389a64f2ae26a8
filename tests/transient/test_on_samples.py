"""The callback `on_samples` receives the trajectory in parts during the run."""

from typing import Any

import numpy as np
import pytest

from fivtui.simulation import simulate
from fivtui.transient.trajectory import COLUMNS, Trajectory

# Sample times, s.
TIMES = np.linspace(0.0, 60.0, 6001)


@pytest.mark.parametrize(
    "options",
    [{"kernel": "compiled"}, {"kernel": "interpreted"}, {"method": "fmu"}],
    ids=["compiled", "interpreted", "fmu"],
)
def test_parts_of_the_trajectory_are_passed_to_the_callback_in_order(
    options: dict[str, Any],
) -> None:
    parts: list[Trajectory] = []
    run = simulate(t_end=60.0, samples=TIMES, on_samples=parts.append, **options)
    assert len(parts) > 1
    joined = Trajectory.joined(parts)
    assert run.trajectory is not None
    for column in COLUMNS:
        complete = getattr(run.trajectory, column.name)
        assert np.array_equal(getattr(joined, column.name), complete[: joined.t.size]), column
    # The compiled kernel does not pass on its last samples: they are too few for a part.
    assert joined.t.size > 2 * TIMES.size // 3


def test_no_part_is_empty_when_samples_are_rare() -> None:
    parts: list[Trajectory] = []
    times = [0.0, 500.0, 1000.0]
    simulate(t_end=1000.0, kernel="interpreted", samples=times, on_samples=parts.append)
    assert [t for part in parts for t in part.t] == times
    assert all(part.t.size for part in parts)

"""Long computations check for cancellation within every piece of work."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fivtui.model import System
from fivtui.model.errors import Cancelled
from fivtui.model.parameters import Parameters
from fivtui.orbits.attractor_continuation import continuation
from fivtui.orbits.attractor_search import coexistence, find_attractors
from fivtui.orbits.basins import basin, escape_offset
from fivtui.orbits.curves.cycle_branches import branch
from fivtui.simulation import simulate
from fivtui.transient import integrate

P = Parameters(F=120.0)
Go = Callable[[float], bool]
SEARCHES: dict[str, Callable[[Go], Any]] = {
    "attractors": lambda go: find_attractors(System(P), kernel="interpreted", progress=go),
    "coexistence": lambda go: coexistence(System(P), kernel="interpreted", progress=go),
    "escape": lambda go: escape_offset(System(P), kernel="interpreted", progress=go),
    "basin": lambda go: basin(
        P, {"x0": [0.0, 1.0], "y0": [0.0, 1.0]}, kernel="interpreted", progress=go
    ),
    "continuation": lambda go: continuation(
        P, "F", [110.0, 120.0], kernel="interpreted", progress=go
    ),
}


def test_a_branch_is_cancelled_between_two_motions() -> None:
    looks: list[float] = []

    def look(fraction: float) -> bool:
        looks.append(fraction)
        return len(looks) < 20

    with pytest.raises(Cancelled):
        branch(P, "mu", progress=look)
    assert len(looks) == 20
    assert looks == sorted(looks)


@pytest.mark.parametrize("name", SEARCHES)
def test_a_search_is_cancelled_within_a_motion(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    within = False

    def watched(*args: Any, **options: Any) -> Any:
        nonlocal within
        within = True
        try:
            return integrate(*args, **options)
        finally:
            within = False

    monkeypatch.setattr("fivtui.orbits.explorer.integrate", watched)
    with pytest.raises(Cancelled):
        SEARCHES[name](lambda _fraction: not within)


@pytest.mark.parametrize("method", ["taylor", "rk4", "scipy-dop853"])
def test_cancellation_is_checked_every_few_steps(method: str) -> None:
    looks = 0

    def look(_fraction: float) -> bool:
        nonlocal looks
        looks += 1
        return True

    options = {"kernel": "interpreted"} if method == "taylor" else {}
    run = simulate(t_end=5.0, method=method, progress=look, **options)  # type: ignore[arg-type]
    assert looks >= run.stats.steps // 32


def test_an_exact_solution_is_cancelled_between_its_samples() -> None:
    times = np.linspace(0.0, 100.0, 20_001)
    looks: list[float] = []

    def go_on(fraction: float) -> bool:
        looks.append(fraction)
        return looks.count(1.0) < 3

    p = Parameters(k_nl=0.0)
    with pytest.raises(Cancelled):
        simulate(p, t_end=100.0, separation=False, samples=times, progress=go_on)
    assert looks == sorted(looks)

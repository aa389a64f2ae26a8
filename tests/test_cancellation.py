"""Long computations can be cancelled between and within the motions that they integrate."""

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

# The base set under a preload F of 120 N.
P = Parameters(F=120.0)
ProgressCallback = Callable[[float], bool]
SEARCHES: dict[str, Callable[[ProgressCallback], Any]] = {
    "attractors": lambda progress: find_attractors(
        System(P), kernel="interpreted", progress=progress
    ),
    "coexistence": lambda progress: coexistence(System(P), kernel="interpreted", progress=progress),
    # The vertical offset from the equilibrium from which the slider does not return.
    "escape": lambda progress: escape_offset(System(P), kernel="interpreted", progress=progress),
    "basin": lambda progress: basin(
        P, {"x0": [0.0, 1.0], "y0": [0.0, 1.0]}, kernel="interpreted", progress=progress
    ),
    "continuation": lambda progress: continuation(
        P, "F", [110.0, 120.0], kernel="interpreted", progress=progress
    ),
}


def test_a_branch_is_cancelled_between_two_motions() -> None:
    fractions: list[float] = []

    def report(fraction: float) -> bool:
        fractions.append(fraction)
        return len(fractions) < 20

    with pytest.raises(Cancelled):
        branch(P, "mu", progress=report)
    assert len(fractions) == 20
    assert fractions == sorted(fractions)


@pytest.mark.parametrize("name", SEARCHES)
def test_a_search_is_cancelled_within_a_motion(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    in_motion = False

    def watch_integrate(*args: Any, **options: Any) -> Any:
        nonlocal in_motion
        in_motion = True
        try:
            return integrate(*args, **options)
        finally:
            in_motion = False

    monkeypatch.setattr("fivtui.orbits.explorer.integrate", watch_integrate)
    with pytest.raises(Cancelled):
        SEARCHES[name](lambda _fraction: not in_motion)


@pytest.mark.parametrize("method", ["taylor", "rk4", "scipy-dop853"])
def test_cancellation_is_checked_every_few_steps(method: str) -> None:
    calls = 0

    def report(_fraction: float) -> bool:
        nonlocal calls
        calls += 1
        return True

    # Only the Taylor method has kernels; the compiled one reports every 256 steps.
    options = {"kernel": "interpreted"} if method == "taylor" else {}
    run = simulate(t_end=5.0, method=method, progress=report, **options)  # type: ignore[arg-type]
    assert calls >= run.stats.steps // 32


def test_an_exact_solution_is_cancelled_between_its_samples() -> None:
    times = np.linspace(0.0, 100.0, 20_001)
    fractions: list[float] = []

    def report(fraction: float) -> bool:
        fractions.append(fraction)
        # The search for extremes reports 1 at its end, then each chunk of samples reports 1: cancel
        # at the second chunk.
        return fractions.count(1.0) < 3

    # Without the cubic term and separation the solution is exact, by the matrix exponential.
    linear = Parameters(k_nl=0.0)
    with pytest.raises(Cancelled):
        simulate(linear, t_end=100.0, separation=False, samples=times, progress=report)
    assert fractions == sorted(fractions)

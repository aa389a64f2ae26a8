"""The benchmark harness at small scale: results are right; times are not judged."""

import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from fivtui.model.slider_belt import State

from .benchmarks import fmu_host
from .benchmarks.peers import missing_packages, peers
from .benchmarks.solvers import COMPILED, OWN, Run, Solver
from .benchmarks.speed import least_of, least_times
from .benchmarks.work_precision import Measurement, cheapest, draw, measure, ratio_to, table
from .references import REFERENCES, Reference

SCENE = REFERENCES["strong-friction"]


def keep_middle_setting(solver: Solver) -> Solver:
    middle = len(solver.settings) // 2
    return Solver(solver.name, solver.settings[middle : middle + 1], solver.prepare)


def test_every_installed_solver_computes_the_scene(tmp_path: Path) -> None:
    solvers = [keep_middle_setting(solver) for solver in OWN if "rk4" not in solver.name]
    measured = measure(
        SCENE, solvers + [keep_middle_setting(solver) for solver in peers()], seconds=0.0, rounds=1
    )
    assert {entry.solver for entry in measured} >= {solver.name for solver in solvers}
    for entry in measured:
        assert entry.error < 5e-2, entry.solver
    draw(measured, "miniature", tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
    assert (
        len(missing_packages())
        + len({entry.solver for entry in measured} - {solver.name for solver in solvers})
        >= 4
    )


def test_a_failing_solver_is_omitted_and_reported() -> None:
    def broken(_scene: Reference, _start: State, _setting: float) -> Run:
        def run() -> Sequence[float]:
            raise ArithmeticError("no")

        return run

    messages: list[str] = []
    assert measure(SCENE, [Solver("broken", [1.0], broken)], rounds=1, report=messages.append) == []
    assert "broken at 1: no" in messages


def test_solvers_are_compared_by_their_cheapest_setting_that_reaches_an_error() -> None:
    measured = [
        Measurement(COMPILED, 1e-3, 1e-4, 1.0),
        Measurement(COMPILED, 1e-6, 1e-7, 2.0),
        Measurement("other", 1e-3, 1e-5, 8.0),
        Measurement("other", 1e-6, 1e-6, 4.0),
        Measurement("hopeless", 1.0, 1.0, 1e-3),
    ]
    assert cheapest(measured, "other", 1e-5) == 4.0
    assert math.isinf(cheapest(measured, "other", 1e-7))
    assert ratio_to(measured, "other", [1e-4, 1e-6, 1e-7]) == pytest.approx(math.sqrt(4.0 * 2.0))
    assert ratio_to(measured, "hopeless", [1e-4]) is None
    assert table(measured, [1e-4, 1e-7])[2] == ["hopeless", "–", "–", "–"]


@pytest.mark.host
@pytest.mark.skipif(
    sys.platform != "linux" or shutil.which("cc") is None,
    reason="the host is for Linux, and needs a compiler",
)
def test_a_host_in_c_steps_every_available_fmu(tmp_path: Path) -> None:
    host = fmu_host.compile_c(tmp_path, "fmu_host.c", "-ldl")
    fmus = fmu_host.build_fmus(tmp_path)
    assert {"bouncing ball in C", "native"} <= set(fmus)
    for fmu in fmus.values():
        assert min(fmu_host.measure_cost(host, fmu, 1e-3, count=50, rounds=1)) > 0.0


@pytest.mark.parametrize("chosen", ["compiled", pytest.param("", marks=pytest.mark.whole)])
def test_every_speed_workload_runs(chosen: str) -> None:
    times = least_times(chosen, seconds=0.0)
    assert len(times) > 1
    assert least_of([times, dict.fromkeys(times, 1e-9)]) == dict.fromkeys(times, 1e-9)
    assert min(times.values()) > 0.0

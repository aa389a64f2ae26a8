"""The benchmark harness at small scale: results are right; times are not judged.

Peers are solvers of other packages.
"""

import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from fivtui.model.slider_belt import State

from .benchmarks import fmu_host
from .benchmarks.peers import missing_packages, peers
from .benchmarks.solvers import COMPILED, FIVTUI_SOLVERS, Run, Solver
from .benchmarks.speed import least_of, least_times
from .benchmarks.work_precision import Measurement, cheapest, draw, measure, ratio_to, table
from .references import REFERENCES, Reference

SCENE = REFERENCES["strong-friction"]


def keep_middle_setting(solver: Solver) -> Solver:
    middle = len(solver.settings) // 2
    return Solver(solver.name, solver.settings[middle : middle + 1], solver.prepare)


def test_every_installed_solver_computes_the_scene(tmp_path: Path) -> None:
    # The steps of RK4 are unstable in this scene.
    own_solvers = [
        keep_middle_setting(solver) for solver in FIVTUI_SOLVERS if "rk4" not in solver.name
    ]
    peer_solvers = [keep_middle_setting(solver) for solver in peers()]
    measured = measure(SCENE, own_solvers + peer_solvers, seconds=0.0, rounds=1)
    measured_names = {entry.solver for entry in measured}
    own_names = {solver.name for solver in own_solvers}
    assert measured_names >= own_names
    for entry in measured:
        assert entry.error < 5e-2, entry.solver
    draw(measured, "miniature", tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
    # Each of four packages is missing, or adds at least one measured solver.
    assert len(missing_packages()) + len(measured_names - own_names) >= 4


def test_a_failing_solver_is_omitted_and_reported() -> None:
    def broken(_scene: Reference, _start: State, _setting: float) -> Run:
        def run() -> Sequence[float]:
            raise ArithmeticError("no")

        return run

    messages: list[str] = []
    assert measure(SCENE, [Solver("broken", [1.0], broken)], rounds=1, report=messages.append) == []
    assert "broken at 1: no" in messages


def test_solvers_are_compared_by_their_cheapest_setting_that_reaches_an_error() -> None:
    # COMPILED names fivtui's compiled solver, to which the others are compared.
    measured = [
        Measurement(COMPILED, setting=1e-3, error=1e-4, cpu_s=1.0),
        Measurement(COMPILED, setting=1e-6, error=1e-7, cpu_s=2.0),
        Measurement("other", setting=1e-3, error=1e-5, cpu_s=8.0),
        Measurement("other", setting=1e-6, error=1e-6, cpu_s=4.0),
        Measurement("hopeless", setting=1.0, error=1.0, cpu_s=1e-3),
    ]
    assert cheapest(measured, "other", 1e-5) == 4.0
    assert math.isinf(cheapest(measured, "other", 1e-7))
    # The geometric mean of 4 s / 1 s and 4 s / 2 s; "other" does not reach 1e-7.
    assert ratio_to(measured, "other", [1e-4, 1e-6, 1e-7]) == pytest.approx(math.sqrt(4.0 * 2.0))
    assert ratio_to(measured, "hopeless", [1e-4]) is None
    # A row for each solver: name, times at both errors, ratio.
    *_, hopeless_row = table(measured, [1e-4, 1e-7])
    assert hopeless_row == ["hopeless", "–", "–", "–"]


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
    # In an invented second round every workload takes less time.
    short_times = dict.fromkeys(times, 1e-9)
    assert least_of([times, short_times]) == short_times
    assert min(times.values()) > 0.0

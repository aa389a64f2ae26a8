"""A communication step of the FMU costs little more than one that does nothing."""

from pathlib import Path

from fmu_src.builder import build_fmu
from tests.benchmarks.fmu import (
    best_of,
    c_no_op,
    cost_of_a_simulation,
    cost_of_a_step,
    python_no_op,
)


def test_a_step_costs_at_most_twice_a_step_that_does_nothing(tmp_path: Path) -> None:
    fmus = {"ours": build_fmu(tmp_path / "ours.fmu"), "no-op": python_no_op(tmp_path)}
    costs = best_of(cost_of_a_step, fmus)
    assert costs["ours"] <= 2.0 * costs["no-op"]


def test_the_fmus_that_the_benchmark_compares_with_run(tmp_path: Path) -> None:
    python = python_no_op(tmp_path)
    native = c_no_op(tmp_path, python)
    for fmu in (python, *([] if native is None else [native])):
        assert cost_of_a_simulation(fmu) > 0.0

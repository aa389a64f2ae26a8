"""A run with its derivatives equals the plain run to the last bit, on every instruction set.

A varied run has derivatives by numbers that change its start and parameters. A seed is the
direction in which such a number changes them.
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import fivtui
import hatch_build
from fivtui.kernel import Kernel, Status, VariedRun, load_kernel, native
from fivtui.kernel.field_text import equation_headers
from fivtui.kernel.runs import MAX_SEEDS
from fivtui.taylor.variation import apply_saltation
from tests.support.kernels import GCC

from .test_same_bits import (
    COMPARED_SETS,
    Members,
    assert_same_bits,
    processor_has,
    random_members,
    single_runs,
    suitable_tolerance,
)

NO_TIMES = np.empty(0)


def varied_runs(
    kernel: Kernel,
    inputs: Members,
    t_end: float,
    order: int,
    count: int,
    budget: int = 5000,
    times: np.ndarray = NO_TIMES,
) -> list[VariedRun]:
    """Ended runs with derivatives in random directions of starts and parameters."""
    seeds = np.random.default_rng(count).normal(size=(count, 13))
    runs = []
    for parameters, separation, start in zip(*inputs, strict=True):
        run = kernel.begin_varied_run(
            np.array(parameters),
            np.array(start),
            seeds,
            separation=bool(separation),
            t_end=t_end,
            tol=suitable_tolerance(order),
            order=order,
            times=times,
        )
        while run.advance(budget) is Status.RUNNING:
            pass
        runs.append(run)
    return runs


def derivative_numbers(runs: list[VariedRun]) -> np.ndarray:
    """All numbers of the derivatives, and (ẋ, ẍ, ẏ, ÿ) at the end, in one array."""
    parts = [[run.derivatives.ravel(), run.extremes.ravel(), np.array(run.rate)] for run in runs]
    return np.array([np.concatenate(part) for part in parts])


@pytest.mark.parametrize(("order", "count"), [(8, 1), (12, 8), (16, 9), (20, 16)])
def test_derivatives_change_no_bit_of_a_run(order: int, count: int) -> None:
    inputs = random_members(40, order)
    kernel = load_kernel()
    runs = varied_runs(kernel, inputs, 10.0, order, count)
    outcomes = np.array([run.outcome for run in runs])
    assert_same_bits(outcomes, single_runs(kernel, inputs, 10.0, order))


def test_pauses_and_samples_change_no_bit() -> None:
    inputs = random_members(10, 7)
    kernel = load_kernel()
    times = np.linspace(0.0, 5.0, 101)
    paused = varied_runs(kernel, inputs, 5.0, 20, 5, budget=3, times=times)
    runs = varied_runs(kernel, inputs, 5.0, 20, 5)
    assert_same_bits(derivative_numbers(paused), derivative_numbers(runs))
    sampled = varied_runs(kernel, inputs, 5.0, 20, 5, times=times)
    assert_same_bits(
        np.array([run.samples.ravel() for run in paused]),
        np.array([run.samples.ravel() for run in sampled]),
    )


def test_samples_are_the_ends_of_shorter_runs() -> None:
    inputs = random_members(10, 3)
    kernel = load_kernel()
    times = np.array([0.0, 0.7, 1.9, 1.9, 3.0])
    runs = varied_runs(kernel, inputs, 3.0, 20, 9, times=times)
    for index, t_end in enumerate(times[1:-1], 1):
        for run, shorter in zip(runs, varied_runs(kernel, inputs, t_end, 20, 9), strict=True):
            expected = np.array([shorter.outcome[:4], *shorter.derivatives])
            np.testing.assert_allclose(run.samples[index], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("instruction_set", COMPARED_SETS)
def test_instruction_sets_give_the_same_derivatives(instruction_set: str) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    inputs = random_members(12, 9)
    derivatives = varied_runs(Kernel(instruction_set), inputs, 4.0, 20, 13)
    assert_same_bits(
        derivative_numbers(derivatives),
        derivative_numbers(varied_runs(load_kernel(), inputs, 4.0, 20, 13)),
    )


@pytest.mark.whole
@pytest.mark.host
def test_another_compiler_gives_the_same_derivatives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    inputs = random_members(12, 9)
    expected = derivative_numbers(varied_runs(load_kernel(), inputs, 4.0, 20, 13))
    monkeypatch.setattr(hatch_build, "_compilers", lambda _root: [GCC])
    folder = Path(fivtui.__file__).parent / "kernel"
    hatch_build.compile_kernel(folder, tmp_path / native._LIBRARY.name)
    monkeypatch.setattr(native, "_LIBRARY", tmp_path / native._LIBRARY.name)
    kernel = Kernel()
    assert kernel.compiler == "gcc"
    assert_same_bits(derivative_numbers(varied_runs(kernel, inputs, 4.0, 20, 13)), expected)


def test_no_seeds_or_more_than_the_limit_are_refused() -> None:
    inputs = random_members(1, 1)
    for count in (0, MAX_SEEDS + 1):
        with pytest.raises(ValueError, match="seeds: must be 1 to 16"):
            varied_runs(load_kernel(), inputs, 1.0, 20, count)


SWITCH_PROGRAM = """
#define LANES 1
#include "deviations.h"
#include <stdio.h>

int main(void)
{
    const double jump[4] = {0.5, -1.0, 0.25, 2.0}, gradient[4] = {1.0, -0.5, 2.0, 0.125};
    /* `Eight` is a vector of eight deviations, all zero but that at index 3. `change` is that of
       the guard by the parameters, `rate` that over time. */
    Deviation d = {{0.0}, {0.0}, {0.0}, {0.0}};
    Eight change = {0.0};
    const double rate = 1.25;
    d.x[3] = 1.5, d.vx[3] = -2.0, d.y[3] = 0.75, d.vy[3] = 4.0, change[3] = 0.3;
    apply_saltation(&d, jump, gradient, change, rate);
    printf("%.17g %.17g %.17g %.17g", d.x[3], d.vx[3], d.y[3], d.vy[3]);
    return 0;
}
"""


@pytest.mark.host
def test_deviations_cross_a_switch_in_c_as_in_python(tmp_path: Path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    source, program = tmp_path / "switch.c", tmp_path / "switch"
    source.write_text(SWITCH_PROGRAM, encoding="utf-8")
    for name, text in equation_headers().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    folder = Path(fivtui.__file__).parent / "kernel"
    includes = [f"-I{tmp_path}", f"-I{folder}"]
    options = ["-std=c11", "-O0", "-Wno-psabi", *includes, str(source), "-o", str(program)]
    subprocess.run(["gcc", *options, "-lm"], check=True, capture_output=True)
    process = subprocess.run([str(program)], check=True, capture_output=True, text=True)
    # The change of the guard: the products of gradient and deviation, and its change by parameters.
    guard_change, rate = 1.5 + 1.0 + 1.5 + 0.5 + 0.3, 1.25
    expected = apply_saltation((1.5, -2.0, 0.75, 4.0), (0.5, -1.0, 0.25, 2.0), guard_change, rate)
    assert [*map(float, process.stdout.split())] == pytest.approx(expected, rel=1e-15)

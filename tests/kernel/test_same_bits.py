"""A member of a batch, the single run and every instruction set give the same bits.

A lane is one element of a SIMD vector. A batch computes its members side by side in lanes, or one
after the other (sequential).
"""

import platform
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fivtui
import hatch_build
from fivtui.kernel import Kernel, RunColumns, Status, load_kernel, native
from fivtui.kernel.lanes import LaneBatch
from fivtui.kernel.sequential import SequentialBatch
from fivtui.model import PARAMETERS, ComputationError
from fivtui.taylor.stepper import MAX_LAW_ORDER
from tests.support.kernels import GCC

COLUMNS = len(RunColumns._fields)
STATUS = RunColumns._fields.index("status")
# Columns of parameters and of belts.
K3, LOAD, K_NL, MU = map(list(PARAMETERS).index, ("k3", "F", "k_nl", "mu"))
V_S = 2
# Flags: whether to find extremes of y, those of x, y and ẋ, and those of y in the second half.
ALL_EXTREMES = (True, True, True)
# Sets to compare with the best one of the processor; the widest is the best wherever it runs.
COMPARED_SETS = native.INSTRUCTION_SETS[:-1]
Members = tuple[np.ndarray, np.ndarray, np.ndarray]


def suitable_tolerance(order: int) -> float:
    """Local tolerance that suits an order of expansion: 0.75 digits for each order."""
    tolerance: float = 10.0 ** (-0.75 * order)
    return tolerance


def random_members(count: int, seed: int) -> Members:
    """Random parameter sets, whether they consider separation, and starts, some on the switch."""
    rng = np.random.default_rng(seed)

    def log_uniform(value: float, factor: float = 3.0) -> np.ndarray:
        return value * factor ** rng.uniform(-1.0, 1.0, count)

    linear = rng.random(count) < 0.15
    columns = [
        log_uniform(5.0),
        log_uniform(100.0),
        log_uniform(50.0),
        60.0 * rng.uniform(0.0, 2.0, count),
    ]
    columns += [0.32 * rng.uniform(0.0, 3.0, count), 0.32 * rng.uniform(0.0, 3.0, count)]
    columns += [rng.uniform(-50.0, 300.0, count), np.where(linear, 0.0, log_uniform(100.0, 10.0))]
    parameters = np.column_stack([*columns, rng.uniform(0.0, 1.5, count)])
    starts = rng.normal(0.0, 1.0, (count, 4)) * np.array([1.0, 3.0, 1.0, 3.0])
    # Starts on the switch, y = 0; in some the coupling force x k3/2 balances F up to rounding.
    starts[rng.random(count) < 0.2, 2] = 0.0
    balanced = (rng.random(count) < 0.1) & (parameters[:, K3] > 0.0)
    starts[balanced, 2] = 0.0
    starts[balanced, 3] *= rng.choice([0.0, 1e-16, 1.0], balanced.sum())
    starts[balanced, 0] = parameters[balanced, LOAD] / (0.5 * parameters[balanced, K3])
    return parameters, rng.random(count) < 0.9, starts


def random_belts(inputs: Members, seed: int) -> np.ndarray:
    """Random belts of finite speed for members; some members then start at their belt's speed."""
    rng = np.random.default_rng(seed)
    parameters, _, starts = inputs
    count, mu = len(parameters), parameters[:, MU]
    speed = np.where(rng.random(count) < 0.1, 0.0, rng.uniform(0.0, 4.0, count))
    mu_static = mu * np.where(rng.random(count) < 0.3, 1.0, rng.uniform(1.0, 1.6, count))
    has_law = (rng.random(count) < 0.5) & (mu_static > mu)
    at_belt_speed = rng.random(count) < 0.2
    starts[at_belt_speed, 1] = speed[at_belt_speed]
    v_s = np.where(has_law, 10.0 ** rng.uniform(-1.3, 0.3, count), 0.0)
    return np.column_stack([speed, mu_static, v_s])


def lane_batch(kernel: Kernel, **inputs: Any) -> LaneBatch:
    """A batch in lanes, even where sequential runs are faster."""
    return LaneBatch(kernel._functions, **inputs)


def sequential_batch(
    kernel: Kernel, *, observed: tuple[bool, bool, bool], **inputs: Any
) -> SequentialBatch:
    assert observed == ALL_EXTREMES
    return SequentialBatch(kernel.begin_run, **inputs)


def batch_results(
    kernel: Kernel,
    inputs: Members,
    t_end: float,
    order: int,
    observed: tuple[bool, bool, bool],
    belts: np.ndarray | None = None,
    max_steps: int = 20_000,
    make: Callable[..., LaneBatch | SequentialBatch] = lane_batch,
) -> np.ndarray:
    parameters, separation, starts = inputs
    results = np.empty((len(parameters), COLUMNS))
    # A batch has a cubic spring in all rows or in none, and a friction law in all rows or in none.
    kinds = (parameters[:, K_NL] > 0.0).astype(int)
    if belts is not None:
        kinds += 2 * (belts[:, V_S] > 0.0)
    for kind in np.unique(kinds):
        rows_of_kind = np.flatnonzero(kinds == kind)
        batch = make(
            kernel,
            parameters=parameters[rows_of_kind],
            separation=separation[rows_of_kind],
            starts=starts[rows_of_kind],
            t_end=t_end,
            tol=suitable_tolerance(order),
            order=order,
            max_steps=max_steps,
            observed=observed,
            belts=None if belts is None else belts[rows_of_kind],
        )
        while not batch.done:
            ended = batch.advance(777)
            assert 0.0 <= ended <= len(rows_of_kind)
        results[rows_of_kind] = batch.results
    return results


def single_runs(
    kernel: Kernel, inputs: Members, t_end: float, order: int, belts: np.ndarray | None = None
) -> np.ndarray:
    results = np.empty((len(inputs[0]), COLUMNS))
    for row, (parameters, separation, start) in enumerate(zip(*inputs, strict=True)):
        run = kernel.begin_run(
            np.array(parameters),
            np.array(start),
            separation=bool(separation),
            t_end=t_end,
            tol=suitable_tolerance(order),
            order=order,
            belt=None if belts is None else tuple(belts[row].tolist()),
        )
        status = Status.RUNNING
        while status is Status.RUNNING:
            status = run.advance(701)
            assert run.outcome.steps < 20_000
        results[row] = run.outcome
    return results


def assert_same_bits(
    actual: np.ndarray, expected: np.ndarray, columns: list[int] | None = None
) -> None:
    chosen = slice(None) if columns is None else columns
    differing = actual[:, chosen].view(np.int64) != expected[:, chosen].view(np.int64)
    # The sign of zero and the bits of NaN may differ.
    differing &= ~((actual == 0.0) & (expected == 0.0))[:, chosen]
    differing &= ~(np.isnan(actual) & np.isnan(expected))[:, chosen]
    assert not differing.any(), np.argwhere(differing)[:5]


def processor_has(instruction_set: str) -> bool:
    try:
        Kernel(instruction_set)
    except ComputationError:
        return False
    return True


@pytest.mark.parametrize("order", [8, 12, 16, 20])
def test_a_member_of_a_batch_equals_the_single_run_to_the_last_bit(order: int) -> None:
    inputs = random_members(500, order)
    kernel = load_kernel()
    single = single_runs(kernel, inputs, 30.0, order)
    assert (single[:, STATUS] == Status.DONE).all()
    assert_same_bits(batch_results(kernel, inputs, 30.0, order, ALL_EXTREMES), single)


@pytest.mark.parametrize("order", [8, 20])
def test_a_member_on_a_belt_of_finite_speed_equals_the_single_run_to_the_last_bit(
    order: int,
) -> None:
    inputs = random_members(300, order)
    belts = random_belts(inputs, order)
    kernel = load_kernel()
    single = single_runs(kernel, inputs, 15.0, order, belts)
    assert (single[:, STATUS] == Status.DONE).all()
    assert_same_bits(batch_results(kernel, inputs, 15.0, order, ALL_EXTREMES, belts), single)


def test_members_with_a_friction_law_equal_single_runs_to_the_last_bit() -> None:
    inputs = random_members(300, 24)
    belts = random_belts(inputs, 24)
    by_law = belts[:, V_S] > 0.0
    inputs, belts = (inputs[0][by_law], inputs[1][by_law], inputs[2][by_law]), belts[by_law]
    kernel = load_kernel()
    single = single_runs(kernel, inputs, 15.0, MAX_LAW_ORDER, belts)
    assert (single[:, STATUS] == Status.DONE).all()
    assert_same_bits(
        batch_results(kernel, inputs, 15.0, MAX_LAW_ORDER, ALL_EXTREMES, belts), single
    )


def test_sequential_members_equal_those_in_lanes_to_the_last_bit() -> None:
    inputs = random_members(200, 5)
    starts = inputs[2]
    # Two members overflow, one from the start on; some exceed the step limit.
    starts[17], starts[18] = np.inf, 1e200
    belts = random_belts(inputs, 5)
    kernel = load_kernel()
    step_limit = 150
    for belt in (belts, None):
        arguments = (kernel, inputs, 15.0, 20, ALL_EXTREMES, belt, step_limit)
        side_by_side = batch_results(*arguments)
        one_by_one = batch_results(*arguments, make=sequential_batch)
        assert_same_bits(one_by_one, side_by_side)
        statuses = side_by_side[:, STATUS]
        assert {*statuses} == {Status.DONE, Status.OVERFLOW, Status.STEP_LIMIT}


def test_members_on_belts_run_in_lanes_if_the_processor_has_fused_multiply_add(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    inputs = random_members(10, 6)
    arguments: dict[str, Any] = dict(
        zip(("parameters", "separation", "starts"), inputs, strict=True)
    )
    arguments |= {"t_end": 1.0, "tol": 1e-15, "order": 20, "max_steps": 9, "observed": ALL_EXTREMES}
    belts = random_belts(inputs, 6)
    for instruction_set, machine, batch_type in (
        ("baseline", "x86_64", SequentialBatch),
        ("baseline", "aarch64", LaneBatch),
        ("avx2", "x86_64", LaneBatch),
    ):
        kernel = Kernel()
        monkeypatch.setattr(platform, "machine", lambda machine=machine: machine)
        kernel.instruction_set = instruction_set
        assert type(kernel.begin_batch(**arguments, belts=belts)) is batch_type
        assert type(kernel.begin_batch(**arguments)) is LaneBatch


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_on_belts_equal_single_runs_to_the_last_bit(seed: int) -> None:
    inputs = random_members(4000, seed)
    belts = random_belts(inputs, seed)
    kernel = load_kernel()
    single = single_runs(kernel, inputs, 30.0, 20, belts)
    assert_same_bits(batch_results(kernel, inputs, 30.0, 20, ALL_EXTREMES, belts), single)


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_equal_single_runs_to_the_last_bit(seed: int) -> None:
    inputs = random_members(4000, seed)
    kernel = load_kernel()
    single = single_runs(kernel, inputs, 60.0, 20)
    assert_same_bits(batch_results(kernel, inputs, 60.0, 20, ALL_EXTREMES), single)


def test_additional_outputs_change_no_bit() -> None:
    inputs = random_members(300, 3)
    kernel = load_kernel()
    expected = batch_results(kernel, inputs, 30.0, 20, ALL_EXTREMES)
    columns = RunColumns._fields.index
    # The columns before the extremes are those of the motion, which is always computed.
    motion = list(range(columns("x_min")))
    amplitude = [columns("y_min"), columns("y_max")]
    steady = [columns("second_half_min"), columns("second_half_max")]
    for observed, observed_columns in (
        ((False, False, False), []),
        ((True, False, False), amplitude),
        ((False, False, True), steady),
    ):
        results = batch_results(kernel, inputs, 30.0, 20, observed)
        assert_same_bits(results, expected, [*motion, *observed_columns])


@pytest.mark.parametrize("make", [lane_batch, sequential_batch])
def test_progress_counts_ended_runs_and_the_computed_fraction_of_the_others(
    make: Callable[..., LaneBatch | SequentialBatch],
) -> None:
    parameters, separation, starts = random_members(3, 6)
    batch = make(
        load_kernel(),
        parameters=parameters,
        separation=separation,
        starts=starts,
        t_end=30.0,
        tol=1e-15,
        order=20,
        max_steps=20_000,
        observed=ALL_EXTREMES,
        belts=None if make is lane_batch else random_belts((parameters, separation, starts), 6),
    )
    ended = [0.0]
    while not batch.done:
        ended.append(batch.advance(20))
    rises = np.diff(ended)
    assert len(rises) > 10
    assert rises.min() > 0.0
    # Twenty steps never cover a full run.
    assert rises.max() < 1.0
    assert ended[-1] == 3.0


@pytest.mark.parametrize("instruction_set", COMPARED_SETS)
def test_instruction_sets_give_the_same_bits(instruction_set: str) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    inputs = random_members(100, 4)
    kernel, best = Kernel(instruction_set), load_kernel()
    expected = single_runs(best, inputs, 10.0, 20)
    assert_same_bits(batch_results(kernel, inputs, 10.0, 20, ALL_EXTREMES), expected)
    assert_same_bits(single_runs(kernel, inputs, 10.0, 20), expected)
    belts = random_belts(inputs, 4)
    expected = single_runs(best, inputs, 5.0, 20, belts)
    assert_same_bits(batch_results(kernel, inputs, 5.0, 20, ALL_EXTREMES, belts), expected)
    assert_same_bits(single_runs(kernel, inputs, 5.0, 20, belts), expected)
    separation = np.ones(len(inputs[0]), bool)
    starts = kernel.static_starts(inputs[0], separation)
    assert_same_bits(starts, best.static_starts(inputs[0], separation))


@pytest.mark.whole
@pytest.mark.host
def test_another_compiler_gives_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    folder = Path(fivtui.__file__).parent / "kernel"
    monkeypatch.setattr(hatch_build, "_compilers", lambda _root: [GCC])
    assert hatch_build.compile_kernel(folder, tmp_path / native._LIBRARY.name) == "gcc"
    inputs, belt_inputs = random_members(100, 5), random_members(100, 5)
    expected = single_runs(load_kernel(), inputs, 10.0, 20)
    # This changes some starts of `belt_inputs`.
    belts = random_belts(belt_inputs, 5)
    expected_on_belts = single_runs(load_kernel(), belt_inputs, 5.0, 20, belts)
    monkeypatch.setattr(native, "_LIBRARY", tmp_path / native._LIBRARY.name)
    kernel = Kernel()
    assert kernel.compiler == "gcc"
    assert_same_bits(single_runs(kernel, inputs, 10.0, 20), expected)
    assert_same_bits(batch_results(kernel, inputs, 10.0, 20, ALL_EXTREMES), expected)
    assert_same_bits(single_runs(kernel, belt_inputs, 5.0, 20, belts), expected_on_belts)
    assert_same_bits(
        batch_results(kernel, belt_inputs, 5.0, 20, ALL_EXTREMES, belts), expected_on_belts
    )

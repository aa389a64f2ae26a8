"""A member of a batch, the single run and every instruction set give the same bits."""

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
from fivtui.model import ComputationError
from fivtui.taylor.stepper import MAX_LAW_ORDER

COLUMNS = len(RunColumns._fields)
EVERYTHING = (True, True, True)
Members = tuple[np.ndarray, np.ndarray, np.ndarray]


def members(count: int, seed: int) -> Members:
    """Random parameter sets, whether they consider separation, and starts, some on the switch."""
    rng = np.random.default_rng(seed)

    def around(value: float, factor: float = 3.0) -> np.ndarray:
        return value * factor ** rng.uniform(-1.0, 1.0, count)

    linear = rng.random(count) < 0.15
    sets = [around(5.0), around(100.0), around(50.0), 60.0 * rng.uniform(0.0, 2.0, count)]
    sets += [0.32 * rng.uniform(0.0, 3.0, count), 0.32 * rng.uniform(0.0, 3.0, count)]
    sets += [rng.uniform(-50.0, 300.0, count), np.where(linear, 0.0, around(100.0, 10.0))]
    parameters = np.column_stack([*sets, rng.uniform(0.0, 1.5, count)])
    starts = rng.normal(0.0, 1.0, (count, 4)) * np.array([1.0, 3.0, 1.0, 3.0])
    # Starts on the switch, some with forces that balance up to rounding.
    starts[rng.random(count) < 0.2, 2] = 0.0
    balanced = (rng.random(count) < 0.1) & (parameters[:, 3] > 0.0)
    starts[balanced, 2] = 0.0
    starts[balanced, 3] *= rng.choice([0.0, 1e-16, 1.0], balanced.sum())
    starts[balanced, 0] = parameters[balanced, 6] / (0.5 * parameters[balanced, 3])
    return parameters, rng.random(count) < 0.9, starts


def belts_of(inputs: Members, seed: int) -> np.ndarray:
    """Random belts of finite speed for members; some members then start at their belt's speed."""
    rng = np.random.default_rng(seed)
    parameters, _, starts = inputs
    count, mu = len(parameters), parameters[:, 8]
    speed = np.where(rng.random(count) < 0.1, 0.0, rng.uniform(0.0, 4.0, count))
    static = mu * np.where(rng.random(count) < 0.3, 1.0, rng.uniform(1.0, 1.6, count))
    falls = (rng.random(count) < 0.5) & (static > mu)
    at_speed = rng.random(count) < 0.2
    starts[at_speed, 1] = speed[at_speed]
    v_s = np.where(falls, 10.0 ** rng.uniform(-1.3, 0.3, count), 0.0)
    return np.column_stack([speed, static, v_s])


def lanes(kernel: Kernel, **inputs: Any) -> LaneBatch:
    """LaneBatch in lanes, even where runs one after the other are faster."""
    return LaneBatch(kernel._functions, **inputs)


def in_turn(kernel: Kernel, *, observed: tuple[bool, bool, bool], **inputs: Any) -> SequentialBatch:
    assert observed == EVERYTHING
    return SequentialBatch(kernel.begin_run, **inputs)


def in_lanes(
    kernel: Kernel,
    inputs: Members,
    t_end: float,
    order: int,
    observed: tuple[bool, bool, bool],
    belts: np.ndarray | None = None,
    max_steps: int = 20_000,
    make: Callable[..., LaneBatch | SequentialBatch] = lanes,
) -> np.ndarray:
    parameters, separation, starts = inputs
    results = np.empty((len(parameters), COLUMNS))
    kinds = (parameters[:, 7] > 0.0).astype(int)
    if belts is not None:
        kinds += 2 * (belts[:, 2] > 0.0)
    for kind in np.unique(kinds):
        rows_of_kind = np.flatnonzero(kinds == kind)
        work = make(
            kernel,
            parameters=parameters[rows_of_kind],
            separation=separation[rows_of_kind],
            starts=starts[rows_of_kind],
            t_end=t_end,
            tol=10.0 ** (-0.75 * order),
            order=order,
            max_steps=max_steps,
            observed=observed,
            belts=None if belts is None else belts[rows_of_kind],
        )
        while not work.done:
            ended = work.advance(777)
            assert 0.0 <= ended <= len(rows_of_kind)
        results[rows_of_kind] = work.results
    return results


def alone(
    kernel: Kernel, inputs: Members, t_end: float, order: int, belts: np.ndarray | None = None
) -> np.ndarray:
    results = np.empty((len(inputs[0]), COLUMNS))
    for row, (parameters, separation, start) in enumerate(zip(*inputs, strict=True)):
        run = kernel.begin_run(
            np.array(parameters),
            np.array(start),
            separation=bool(separation),
            t_end=t_end,
            tol=10.0 ** (-0.75 * order),
            order=order,
            belt=None if belts is None else tuple(belts[row].tolist()),
        )
        status = Status.RUNNING
        while status is Status.RUNNING:
            status = run.advance(701)
            assert run.outcome.steps < 20_000
        results[row] = run.outcome
    return results


def assert_same(actual: np.ndarray, expected: np.ndarray, columns: list[int] | None = None) -> None:
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
def test_a_member_of_a_batch_is_the_single_run_to_the_last_bit(order: int) -> None:
    inputs = members(500, order)
    kernel = load_kernel()
    single = alone(kernel, inputs, 30.0, order)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, inputs, 30.0, order, EVERYTHING), single)


@pytest.mark.parametrize("order", [8, 20])
def test_a_member_on_a_belt_of_finite_speed_is_the_single_run_to_the_last_bit(order: int) -> None:
    inputs = members(300, order)
    belts = belts_of(inputs, order)
    kernel = load_kernel()
    single = alone(kernel, inputs, 15.0, order, belts)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, inputs, 15.0, order, EVERYTHING, belts), single)


def test_members_that_follow_a_friction_law_are_single_runs_to_the_last_bit() -> None:
    inputs = members(300, 24)
    belts = belts_of(inputs, 24)
    by_law = belts[:, 2] > 0.0
    inputs, belts = (inputs[0][by_law], inputs[1][by_law], inputs[2][by_law]), belts[by_law]
    kernel = load_kernel()
    single = alone(kernel, inputs, 15.0, MAX_LAW_ORDER, belts)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, inputs, 15.0, MAX_LAW_ORDER, EVERYTHING, belts), single)


def test_members_in_turn_are_those_in_lanes_to_the_last_bit() -> None:
    inputs = members(200, 5)
    starts = inputs[2]
    # One member cannot start, one overflows, and some exceed the step limit.
    starts[17], starts[18] = np.inf, 1e200
    belts = belts_of(inputs, 5)
    kernel = load_kernel()
    for belt in (belts, None):
        arguments = (kernel, inputs, 15.0, 20, EVERYTHING, belt, 150)
        side_by_side = in_lanes(*arguments)
        turned = in_lanes(*arguments, make=in_turn)
        assert_same(turned, side_by_side)
        statuses = side_by_side[:, RunColumns._fields.index("status")]
        assert {*statuses} == {Status.DONE, Status.OVERFLOW, Status.STEP_LIMIT}


def test_members_on_belts_are_in_lanes_where_operations_are_fused_in_hardware(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    inputs = members(10, 6)
    arguments: dict[str, Any] = dict(
        zip(("parameters", "separation", "starts"), inputs, strict=True)
    )
    arguments |= {"t_end": 1.0, "tol": 1e-15, "order": 20, "max_steps": 9, "observed": EVERYTHING}
    belts = belts_of(inputs, 6)
    for instruction_set, machine, kind in (
        ("baseline", "x86_64", SequentialBatch),
        ("baseline", "aarch64", LaneBatch),
        ("avx2", "x86_64", LaneBatch),
    ):
        kernel = Kernel()
        monkeypatch.setattr(platform, "machine", lambda machine=machine: machine)
        kernel.instruction_set = instruction_set
        assert type(kernel.begin_batch(**arguments, belts=belts)) is kind
        assert type(kernel.begin_batch(**arguments)) is LaneBatch


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_on_belts_are_the_single_run_to_the_last_bit(seed: int) -> None:
    inputs = members(4000, seed)
    belts = belts_of(inputs, seed)
    kernel = load_kernel()
    single = alone(kernel, inputs, 30.0, 20, belts)
    assert_same(in_lanes(kernel, inputs, 30.0, 20, EVERYTHING, belts), single)


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_are_the_single_run_to_the_last_bit(seed: int) -> None:
    inputs = members(4000, seed)
    kernel = load_kernel()
    single = alone(kernel, inputs, 60.0, 20)
    assert_same(in_lanes(kernel, inputs, 60.0, 20, EVERYTHING), single)


def test_additional_outputs_change_no_bit() -> None:
    inputs = members(300, 3)
    kernel = load_kernel()
    complete = in_lanes(kernel, inputs, 30.0, 20, EVERYTHING)
    state = list(range(12))
    low, high = map(RunColumns._fields.index, ("y_min", "y_max"))
    assert_same(in_lanes(kernel, inputs, 30.0, 20, (False, False, False)), complete, state)
    assert_same(
        in_lanes(kernel, inputs, 30.0, 20, (True, False, False)), complete, [*state, low, high]
    )
    late = [*state, COLUMNS - 2, COLUMNS - 1]
    assert_same(in_lanes(kernel, inputs, 30.0, 20, (False, False, True)), complete, late)


@pytest.mark.parametrize("make", [lanes, in_turn])
def test_the_number_of_runs_ended_rises_with_the_part_of_those_under_way(
    make: Callable[..., LaneBatch | SequentialBatch],
) -> None:
    parameters, separation, starts = members(3, 6)
    work = make(
        load_kernel(),
        parameters=parameters,
        separation=separation,
        starts=starts,
        t_end=30.0,
        tol=1e-15,
        order=20,
        max_steps=20_000,
        observed=EVERYTHING,
        belts=None if make is lanes else belts_of((parameters, separation, starts), 6),
    )
    ended = [0.0]
    while not work.done:
        ended.append(work.advance(20))
    rises = np.diff(ended)
    assert len(rises) > 10
    assert rises.min() > 0.0
    # No single step of the twenty covers the full run.
    assert rises.max() < 1.0
    assert ended[-1] == 3.0


@pytest.mark.parametrize("instruction_set", native.INSTRUCTION_SETS[:-1])
def test_instruction_sets_give_the_same_bits(instruction_set: str) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    inputs = members(100, 4)
    kernel, best = Kernel(instruction_set), load_kernel()
    expected = alone(best, inputs, 10.0, 20)
    assert_same(in_lanes(kernel, inputs, 10.0, 20, EVERYTHING), expected)
    assert_same(alone(kernel, inputs, 10.0, 20), expected)
    belts = belts_of(inputs, 4)
    expected = alone(best, inputs, 5.0, 20, belts)
    assert_same(in_lanes(kernel, inputs, 5.0, 20, EVERYTHING, belts), expected)
    assert_same(alone(kernel, inputs, 5.0, 20, belts), expected)
    separation = np.ones(len(inputs[0]), bool)
    starts = kernel.static_starts(inputs[0], separation)
    assert_same(starts, best.static_starts(inputs[0], separation))


@pytest.mark.whole
@pytest.mark.host
def test_another_compiler_gives_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    folder = Path(fivtui.__file__).parent / "kernel"
    monkeypatch.setattr(hatch_build, "_compilers", lambda: [("gcc", ["gcc"])])
    assert hatch_build.compile_kernel(folder, tmp_path / native._LIBRARY.name) == "gcc"
    inputs = members(100, 5)
    expected = alone(load_kernel(), inputs, 10.0, 20)
    belts = belts_of(inputs, 5)
    on_belts = alone(load_kernel(), inputs, 5.0, 20, belts)
    monkeypatch.setattr(native, "_LIBRARY", tmp_path / native._LIBRARY.name)
    kernel = Kernel()
    assert kernel.compiler == "gcc"
    assert_same(alone(kernel, members(100, 5), 10.0, 20), expected)
    assert_same(in_lanes(kernel, members(100, 5), 10.0, 20, EVERYTHING), expected)
    assert_same(alone(kernel, inputs, 5.0, 20, belts), on_belts)
    assert_same(in_lanes(kernel, inputs, 5.0, 20, EVERYTHING, belts), on_belts)

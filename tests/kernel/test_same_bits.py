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
from fivtui.kernel.in_turn import RunsInTurn
from fivtui.kernel.lanes import Work
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
    # On the switch, and where the forces there balance to rounding.
    starts[rng.random(count) < 0.2, 2] = 0.0
    balanced = (rng.random(count) < 0.1) & (parameters[:, 3] > 0.0)
    starts[balanced, 2] = 0.0
    starts[balanced, 3] *= rng.choice([0.0, 1e-16, 1.0], balanced.sum())
    starts[balanced, 0] = parameters[balanced, 6] / (0.5 * parameters[balanced, 3])
    return parameters, rng.random(count) < 0.9, starts


def belts_of(given: Members, seed: int) -> np.ndarray:
    """Random belts of finite speed for members, some of which then start at the speed of theirs."""
    rng = np.random.default_rng(seed)
    parameters, _, starts = given
    count, mu = len(parameters), parameters[:, 8]
    speed = np.where(rng.random(count) < 0.1, 0.0, rng.uniform(0.0, 4.0, count))
    static = mu * np.where(rng.random(count) < 0.3, 1.0, rng.uniform(1.0, 1.6, count))
    falls = (rng.random(count) < 0.5) & (static > mu)
    at_speed = rng.random(count) < 0.2
    starts[at_speed, 1] = speed[at_speed]
    v_s = np.where(falls, 10.0 ** rng.uniform(-1.3, 0.3, count), 0.0)
    return np.column_stack([speed, static, v_s])


def lanes(kernel: Kernel, **asked: Any) -> Work:
    """Lanes, also where runs in turn are faster."""
    return Work(kernel._functions, **asked)


def in_turn(kernel: Kernel, *, observed: tuple[bool, bool, bool], **asked: Any) -> RunsInTurn:
    assert observed == EVERYTHING
    return RunsInTurn(kernel.begin, **asked)


def in_lanes(
    kernel: Kernel,
    given: Members,
    t_end: float,
    order: int,
    observed: tuple[bool, bool, bool],
    belts: np.ndarray | None = None,
    max_steps: int = 20_000,
    make: Callable[..., Work | RunsInTurn] = lanes,
) -> np.ndarray:
    parameters, separation, starts = given
    results = np.empty((len(parameters), COLUMNS))
    kinds = (parameters[:, 7] > 0.0).astype(int)
    if belts is not None:
        kinds += 2 * (belts[:, 2] > 0.0)
    for kind in np.unique(kinds):
        here = np.flatnonzero(kinds == kind)
        work = make(
            kernel,
            parameters=parameters[here],
            separation=separation[here],
            starts=starts[here],
            t_end=t_end,
            tol=10.0 ** (-0.75 * order),
            order=order,
            max_steps=max_steps,
            observed=observed,
            belts=None if belts is None else belts[here],
        )
        while not work.done:
            ended = work.advance(777)
            assert 0.0 <= ended <= len(here)
        results[here] = work.results
    return results


def alone(
    kernel: Kernel, given: Members, t_end: float, order: int, belts: np.ndarray | None = None
) -> np.ndarray:
    results = np.empty((len(given[0]), COLUMNS))
    for place, (parameters, separation, start) in enumerate(zip(*given, strict=True)):
        run = kernel.begin(
            np.array(parameters),
            np.array(start),
            separation=bool(separation),
            t_end=t_end,
            tol=10.0 ** (-0.75 * order),
            order=order,
            belt=None if belts is None else tuple(belts[place].tolist()),
        )
        status = Status.RUNNING
        while status is Status.RUNNING:
            status = run.advance(701)
            assert run.outcome.steps < 20_000
        results[place] = run.outcome
    return results


def assert_same(one: np.ndarray, other: np.ndarray, columns: list[int] | None = None) -> None:
    chosen = slice(None) if columns is None else columns
    differing = one[:, chosen].view(np.int64) != other[:, chosen].view(np.int64)
    # A zero may have either sign, and what is not a number any bits.
    differing &= ~((one == 0.0) & (other == 0.0))[:, chosen]
    differing &= ~(np.isnan(one) & np.isnan(other))[:, chosen]
    assert not differing.any(), np.argwhere(differing)[:5]


def processor_has(instruction_set: str) -> bool:
    try:
        Kernel(instruction_set)
    except ComputationError:
        return False
    return True


@pytest.mark.parametrize("order", [8, 12, 16, 20])
def test_a_member_of_a_batch_is_the_single_run_to_the_last_bit(order: int) -> None:
    given = members(500, order)
    kernel = load_kernel()
    single = alone(kernel, given, 30.0, order)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, given, 30.0, order, EVERYTHING), single)


@pytest.mark.parametrize("order", [8, 20])
def test_a_member_on_a_belt_of_finite_speed_is_the_single_run_to_the_last_bit(order: int) -> None:
    given = members(300, order)
    belts = belts_of(given, order)
    kernel = load_kernel()
    single = alone(kernel, given, 15.0, order, belts)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, given, 15.0, order, EVERYTHING, belts), single)


def test_members_that_follow_a_friction_law_are_single_runs_to_the_last_bit() -> None:
    given = members(300, 24)
    belts = belts_of(given, 24)
    by_law = belts[:, 2] > 0.0
    given, belts = (given[0][by_law], given[1][by_law], given[2][by_law]), belts[by_law]
    kernel = load_kernel()
    single = alone(kernel, given, 15.0, MAX_LAW_ORDER, belts)
    assert (single[:, RunColumns._fields.index("status")] == Status.DONE).all()
    assert_same(in_lanes(kernel, given, 15.0, MAX_LAW_ORDER, EVERYTHING, belts), single)


def test_members_in_turn_are_those_in_lanes_to_the_last_bit() -> None:
    given = members(200, 5)
    starts = given[2]
    # One does not start, one overflows, some take too many steps.
    starts[17], starts[18] = np.inf, 1e200
    belts = belts_of(given, 5)
    kernel = load_kernel()
    for belt in (belts, None):
        asked = (kernel, given, 15.0, 20, EVERYTHING, belt, 150)
        side_by_side = in_lanes(*asked)
        turned = in_lanes(*asked, make=in_turn)
        assert_same(turned, side_by_side)
        found = side_by_side[:, RunColumns._fields.index("status")]
        assert {*found} == {Status.DONE, Status.OVERFLOW, Status.STEP_LIMIT}


def test_members_on_belts_are_in_lanes_where_operations_are_fused_in_hardware(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = members(10, 6)
    asked: dict[str, Any] = dict(zip(("parameters", "separation", "starts"), given, strict=True))
    asked |= {"t_end": 1.0, "tol": 1e-15, "order": 20, "max_steps": 9, "observed": EVERYTHING}
    belts = belts_of(given, 6)
    for instruction_set, machine, kind in (
        ("baseline", "x86_64", RunsInTurn),
        ("baseline", "aarch64", Work),
        ("avx2", "x86_64", Work),
    ):
        kernel = Kernel()
        monkeypatch.setattr(platform, "machine", lambda machine=machine: machine)
        kernel.instruction_set = instruction_set
        assert type(kernel.work(**asked, belts=belts)) is kind
        assert type(kernel.work(**asked)) is Work


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_on_belts_are_the_single_run_to_the_last_bit(seed: int) -> None:
    given = members(4000, seed)
    belts = belts_of(given, seed)
    kernel = load_kernel()
    single = alone(kernel, given, 30.0, 20, belts)
    assert_same(in_lanes(kernel, given, 30.0, 20, EVERYTHING, belts), single)


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_members_are_the_single_run_to_the_last_bit(seed: int) -> None:
    given = members(4000, seed)
    kernel = load_kernel()
    single = alone(kernel, given, 60.0, 20)
    assert_same(in_lanes(kernel, given, 60.0, 20, EVERYTHING), single)


def test_what_is_required_besides_changes_no_bit() -> None:
    given = members(300, 3)
    kernel = load_kernel()
    whole = in_lanes(kernel, given, 30.0, 20, EVERYTHING)
    state = list(range(12))
    low, high = map(RunColumns._fields.index, ("y_min", "y_max"))
    assert_same(in_lanes(kernel, given, 30.0, 20, (False, False, False)), whole, state)
    assert_same(in_lanes(kernel, given, 30.0, 20, (True, False, False)), whole, [*state, low, high])
    late = [*state, COLUMNS - 2, COLUMNS - 1]
    assert_same(in_lanes(kernel, given, 30.0, 20, (False, False, True)), whole, late)


@pytest.mark.parametrize("make", [lanes, in_turn])
def test_the_number_of_runs_ended_rises_with_the_part_of_those_under_way(
    make: Callable[..., Work | RunsInTurn],
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
    # No step of twenty is more than a part of a run.
    assert rises.max() < 1.0
    assert ended[-1] == 3.0


@pytest.mark.parametrize("instruction_set", native.INSTRUCTION_SETS[:-1])
def test_instruction_sets_give_the_same_bits(instruction_set: str) -> None:
    if not processor_has(instruction_set):
        pytest.skip(f"this processor lacks {instruction_set}")
    given = members(100, 4)
    kernel, best = Kernel(instruction_set), load_kernel()
    expected = alone(best, given, 10.0, 20)
    assert_same(in_lanes(kernel, given, 10.0, 20, EVERYTHING), expected)
    assert_same(alone(kernel, given, 10.0, 20), expected)
    belts = belts_of(given, 4)
    expected = alone(best, given, 5.0, 20, belts)
    assert_same(in_lanes(kernel, given, 5.0, 20, EVERYTHING, belts), expected)
    assert_same(alone(kernel, given, 5.0, 20, belts), expected)
    separation = np.ones(len(given[0]), bool)
    starts = kernel.static_starts(given[0], separation)
    assert_same(starts, best.static_starts(given[0], separation))


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
    given = members(100, 5)
    expected = alone(load_kernel(), given, 10.0, 20)
    belts = belts_of(given, 5)
    on_belts = alone(load_kernel(), given, 5.0, 20, belts)
    monkeypatch.setattr(native, "_LIBRARY", tmp_path / native._LIBRARY.name)
    kernel = Kernel()
    assert kernel.compiler == "gcc"
    assert_same(alone(kernel, members(100, 5), 10.0, 20), expected)
    assert_same(in_lanes(kernel, members(100, 5), 10.0, 20, EVERYTHING), expected)
    assert_same(alone(kernel, given, 5.0, 20, belts), on_belts)
    assert_same(in_lanes(kernel, given, 5.0, 20, EVERYTHING, belts), on_belts)

"""Batches of transients: the same as single runs, whatever else is in the batch."""

import math
import threading
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fivtui import Parameters, simulate, simulate_batch
from fivtui.batch import run as batch_module
from fivtui.batch.result import Batch
from fivtui.batch.run import REQUIREMENTS, Requirement
from fivtui.kernel import Status
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import State
from fivtui.transient.result import Transient
from tests.support.kernels import INTERPRETED
from tests.support.strategies import moderate_parameters, states

GROWING = Parameters(k2=186.0, k_nl=0.0, mu=1.5)


def rows_of(*sets: Parameters) -> np.ndarray:
    """Parameter sets as an array, a row each."""
    return np.array([p.values() for p in sets])


def varied(count: int) -> np.ndarray:
    """Random parameter sets around the base set, a row each."""
    rng = np.random.default_rng(7)
    sets = rows_of(*[Parameters()] * count)
    return np.column_stack(
        [sets[:, column] * rng.uniform(0.5, 1.5, count) for column in range(len(PARAMETERS))]
    )


def assert_identical(first: Batch, second: Batch, order: np.ndarray | None = None) -> None:
    expected, actual = first.to_columns(), second.to_columns()
    assert expected.keys() == actual.keys()
    for name, value in expected.items():
        expected_value = value if order is None else value[order]
        assert np.array_equal(expected_value, actual[name], equal_nan=True), name


def assert_agrees(result: Batch, row: int, run: Transient, *, close: float) -> None:
    """A member of a batch has the results of a run, to the relative tolerance `close`."""
    p = run.parameters
    length = max(run.peak.x_abs, run.peak.y_abs, abs(p.F) / (p.k1 + p.k2 + p.k3))
    speed = length * math.sqrt((p.k1 + p.k2 + p.k3) / p.m)

    def same(actual: float, expected: float, scale: float) -> None:
        assert actual == pytest.approx(expected, rel=close, abs=close * scale)

    assert result.status[row] == Status.DONE
    assert result.t[row] == run.t_end
    for column, name in enumerate(("x", "vx", "y", "vy")):
        scale = speed if name.startswith("v") else length
        same(result.final[row, column], getattr(run.final, name), scale)
    for name in ("y_abs", "y_max", "y_min", "x_abs"):
        same(getattr(result.peak, name)[row], getattr(run.peak, name), length)
    same(result.peak.vx_max[row], run.peak.vx_max, speed)
    same(result.steady.y_half_range[row], run.steady.y_half_range, length)
    # Near a touch y is a parabola in time: an error of y, relative 1e-15, changes the time off the
    # belt by about its square root, 3e-8.
    time_tolerance = max(close, 3e-8) * run.t_end
    assert result.events.separated_time[row] == pytest.approx(
        run.events.separated_time, rel=close, abs=time_tolerance
    )


@settings(max_examples=30)
@given(
    st.lists(st.tuples(moderate_parameters(), states(), st.booleans()), min_size=1, max_size=12),
    st.sampled_from([1e-12, 1e-9, 1e-5]),
)
def test_any_members_are_those_of_single_runs(
    members: list[tuple[Parameters, State, bool]], tol: float
) -> None:
    result = simulate_batch(
        rows_of(*(p for p, _, _ in members)),
        t_end=8.0,
        tol=tol,
        start=np.array([start for _, start, _ in members]),
        separation=np.array([separation for _, _, separation in members]),
    )
    for row, (p, start, separation) in enumerate(members):
        try:
            run = simulate(
                p, t_end=8.0, tol=tol, start=start, separation=separation, kernel="interpreted"
            )
        except ComputationError as error:
            failure = result.failure(row)
            assert failure is not None
            assert failure.advice == error.advice  # noqa: PT017
            continue
        assert_agrees(result, row, run, close=1e-9 if tol < 1e-7 else 1e-3)


def test_results_do_not_depend_on_other_members_order_or_workers() -> None:
    sets = varied(150)
    sets[::7, list(PARAMETERS).index("k_nl")] = 0.0
    flags = np.arange(len(sets)) % 3 > 0
    options = {"t_end": 20.0, "tol": 1e-9}
    complete = simulate_batch(sets, separation=flags, workers=1, **options)  # type: ignore[arg-type]
    assert (complete.status == Status.DONE).sum() > 100
    for workers in (2, 5):
        repeated = simulate_batch(sets, separation=flags, workers=workers, **options)  # type: ignore[arg-type]
        assert_identical(complete, repeated)
    order = np.random.default_rng(3).permutation(len(sets))
    shuffled = simulate_batch(sets[order], separation=flags[order], **options)  # type: ignore[arg-type]
    assert_identical(complete, shuffled, order)
    for index in range(0, len(sets), 10):
        alone = simulate_batch(sets[index : index + 1], separation=flags[index], **options)  # type: ignore[arg-type]
        assert_identical(complete, alone, np.array([index]))


@pytest.mark.parametrize("requirement", REQUIREMENTS)
def test_only_what_is_required_is_computed(requirement: Requirement) -> None:
    sets = varied(20)
    complete = simulate_batch(sets, t_end=10.0, require=REQUIREMENTS)
    part = simulate_batch(sets, t_end=10.0, require={requirement})
    for name in set(REQUIREMENTS) - {requirement}:
        with pytest.raises(InputError, match=f"{name}: not required"):
            getattr(part, name)
    assert getattr(part, requirement) is not None
    expected = complete.to_columns()
    for name, value in part.to_columns().items():
        expected_values = expected[name]
        assert np.allclose(value, expected_values, rtol=1e-11, atol=1e-11, equal_nan=True), name


def test_names_are_broadcast_over_the_base_set() -> None:
    result = simulate_batch(
        {"F": [60.0, 100.0], "mu": 0.6}, base=Parameters(c1=0.5), t_end=5.0, require={"final"}
    )
    for row, force in enumerate((60.0, 100.0)):
        run = simulate(Parameters(F=force, mu=0.6, c1=0.5), t_end=5.0, kernel="interpreted")
        assert result.final[row, 0] == pytest.approx(run.final.x, rel=1e-12)
    single = simulate_batch({}, t_end=1.0)
    assert single.status.shape == (1,)


def test_an_empty_batch_is_empty() -> None:
    result = simulate_batch(np.empty((0, 9)))
    assert {value.shape[0] for value in result.to_columns().values()} == {0}
    assert result.failed.size == 0


def test_a_member_that_fails_has_a_reason_and_does_not_change_others() -> None:
    good_sets = varied(30)
    bad = np.array([0, 7, 11, 31])
    sets = np.repeat(rows_of(GROWING), len(good_sets) + len(bad), axis=0)
    # With separation ignored, the growing motions have no bound.
    flags = np.ones(len(sets), bool)
    flags[bad] = False
    good = np.flatnonzero(flags)
    sets[good] = good_sets
    options = {"t_end": 3000.0, "tol": 1e-3}
    result = simulate_batch(sets, separation=flags, **options)  # type: ignore[arg-type]
    assert result.failed.tolist() == bad.tolist()
    assert_identical(result, simulate_batch(good_sets, **options), good)  # type: ignore[arg-type]
    with pytest.raises(ComputationError) as caught:
        simulate(GROWING, separation=False, kernel="compiled", **options)  # type: ignore[arg-type]
    for index in bad.tolist():
        failure = result.failure(index)
        assert failure is not None
        assert failure.advice == caught.value.advice
        assert failure.why == caught.value.why
        for name, value in result.to_columns().items():
            if value.dtype == np.float64 and name != "t":
                assert np.isnan(value[index]).all(), name
    assert result.failure(1) is None


def test_other_failures_are_reported() -> None:
    limited = simulate_batch({"F": [80.0]}, max_steps=50)
    assert limited.status[0] == Status.STEP_LIMIT
    assert limited.steps[0] == 50
    assert str(limited.failure(0)).startswith("50 steps reach t = ")
    stiff = Parameters(m=1e-12, k2=1e12, k_nl=0.0)
    stalled = simulate_batch(
        rows_of(stiff), t_end=1e7, max_steps=10_000, start=(0.0, 0.0, 1.0, -1.0)
    )
    assert stalled.status[0] in (Status.STALLED, Status.STEP_LIMIT)
    lifted = simulate_batch({"F": [-5.0, 80.0], "k3": 0.0}, t_end=1.0)
    assert lifted.status.tolist() == [Status.NO_START, Status.DONE]
    assert str(lifted.failure(0)).startswith("no equilibrium: F = -5 N")
    assert lifted.t[0] == 0.0
    assert lifted.failure(-1) is None


def test_work_is_cancelled_at_the_next_report() -> None:
    shares: list[float] = []

    def progress(fraction: float) -> bool:
        shares.append(fraction)
        return fraction < 0.02

    with pytest.raises(Cancelled):
        simulate_batch({"F": np.linspace(50.0, 100.0, 400)}, t_end=1e4, progress=progress)
    # No callback follows the one that cancelled, and the work is incomplete.
    assert [fraction >= 0.02 for fraction in shares] == [False] * (len(shares) - 1) + [True]
    assert shares[-1] < 1.0
    assert shares == sorted(shares)
    assert not [t for t in threading.enumerate() if t.name.startswith("batch")]


def test_progress_rises_to_one() -> None:
    shares: list[float] = []

    def progress(fraction: float) -> bool:
        shares.append(fraction)
        return True

    simulate_batch({"F": np.linspace(50.0, 100.0, 4000)}, t_end=100.0, tol=1e-3, progress=progress)
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert len(shares) > 3


def test_an_exception_in_a_worker_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> object:
        raise OSError("no more memory")

    monkeypatch.setattr(batch_module._BatchRun, "_integrate", broken)
    with pytest.raises(OSError, match="no more memory"):
        simulate_batch({"F": [1.0, 2.0]}, t_end=1.0)


def test_memory_does_not_grow_with_the_horizon() -> None:
    sets = varied(64)

    def peak_memory(t_end: float) -> int:
        tracemalloc.start()
        simulate_batch(sets, t_end=t_end, tol=1e-3)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    peak_memory(1.0)
    assert peak_memory(300.0) < peak_memory(1.0) + 20_000


def test_memory_is_that_of_the_inputs_and_outputs() -> None:
    count = 200_000
    forces = np.linspace(10.0, 100.0, count)
    tracemalloc.start()
    result = simulate_batch({"F": forces}, t_end=1e-3, tol=1e-2, require={"peak"})
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    outputs = sum(value.nbytes for value in result.to_columns().values())
    assert peak < outputs + 4_000_000


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameters": {"G": [1.0]}}, "did you mean F|unknown parameter 'G'"),
        ({"parameters": {"F": [1.0, 2.0], "mu": [1.0] * 3}}, r"do not fit .*F \(2,\), mu \(3,\)"),
        ({"parameters": {"F": [[1.0]]}}, "one axis"),
        ({"parameters": {"F": ["much"]}}, "F: not an array of numbers"),
        ({"parameters": {"F": [1.0, math.nan]}}, "member 1: F = nan"),
        ({"parameters": {"m": [1.0, 2.0, 0.0]}}, "member 2: m = 0: must be from 1e-12"),
        ({"parameters": np.ones((2, 8))}, r"shape \(2, 8\); must be \(n, 9\)"),
        ({"start": [1.0, 2.0]}, r"shape \(2,\); must be static"),
        ({"start": "moving"}, "start = 'moving'"),
        ({"start": [1.0, 2.0, math.inf, 0.0]}, "not all finite"),
        ({"separation": "no"}, "separation: must be a bool"),
        ({"separation": np.ones(3, bool)}, "array of 2"),
        ({"tol": 1.0}, "tol = 1: must be from"),
        ({"t_end": -1.0}, "t_end = -1: must be above"),
        ({"workers": 0}, "workers = 0"),
        ({"max_steps": 0}, "max_steps = 0: must be a whole number, at least 1"),
        ({"max_steps": 0.5}, "max_steps = 0.5: must be a whole number"),
        ({"require": {"peaks"}}, "did you mean peak"),
    ],
)
def test_a_wrong_request_is_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate_batch(**{"parameters": {"F": [1.0, 2.0]}, **options})  # type: ignore[arg-type]


def test_without_a_compiled_kernel_members_are_interpreted() -> None:
    sets = rows_of(
        Parameters(),
        Parameters(k_nl=0.0, F=30.0),
        Parameters(F=-5.0, k3=0.0),
        GROWING,
        Parameters(),
    )
    flags = np.array([True, True, True, False, True])
    compiled = simulate_batch(sets, separation=flags, t_end=40.0)
    with INTERPRETED:
        interpreted = simulate_batch(sets, separation=flags, t_end=40.0)
        halted = simulate_batch(sets[:1], t_end=40.0, max_steps=5)
        with pytest.raises(Cancelled):
            simulate_batch(sets, t_end=40.0, progress=lambda fraction: fraction == 0.0)
    assert (interpreted.status == compiled.status).all()
    assert halted.status[0] == Status.STEP_LIMIT
    assert halted.steps[0] == 5
    # Only the slider without equilibrium fails: the growing motion does not overflow within 40 s.
    assert set(interpreted.status) == {Status.DONE, Status.NO_START}
    for name, value in compiled.to_columns().items():
        assert interpreted.to_columns()[name] == pytest.approx(
            value, rel=1e-9, abs=1e-9, nan_ok=True
        ), name

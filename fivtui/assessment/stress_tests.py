"""Stress tests: every method on extreme scenes, compared with the true result.

The true results come from an independent solver in quadruple precision (``tests/references``).
Every test is limited by a number of steps, never by a clock. In their names and meanings the switch
is y = 0, where contact changes to separation.
"""

import enum
import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from typing import Final

from fivtui.model import (
    Cancelled,
    ComputationError,
    InputError,
    OnProgress,
    Parameters,
    Progress,
    check_known,
)
from fivtui.simulation import simulate
from fivtui.transient import KernelChoice, Start, Transient

TRUTH_FILE: Final = "stress_truth.json"
_TOL: Final = 1e-9
# Error limit of a right result: the larger of _ERROR_LIMIT and _TOL_MULTIPLE times the tolerance.
_ERROR_LIMIT: Final = 1e-4
_TOL_MULTIPLE: Final = 20.0
# An FMU run has no limit of steps. It is cancelled after this number of progress calls, of which
# there is one per 128 communication steps.
_PROGRESS_CALLS: Final = 100
_STEPS_PER_CALL: Final = 128


@dataclass(frozen=True, slots=True)
class StressTest:
    """A scene on which solvers fail; `meaning` says what is extreme about it.

    `same_result_as` names the test whose true result this one shares; empty if it has its own.
    `has_result` is false if no finite result exists.
    """

    name: str
    meaning: str
    parameters: Parameters
    t_end: float
    tol: float = _TOL
    separation: bool = True
    start: Start = "static"
    same_result_as: str = ""
    has_result: bool = True


@dataclass(frozen=True, slots=True)
class TrueResult:
    """The true result of a stress test: final state, peaks and separations, in SI units."""

    x: float
    vx: float
    y: float
    vy: float
    y_abs: float
    x_abs: float
    separations: int
    separated_time: float


class StressVerdict(enum.StrEnum):
    """Whether a result is right, wrong, or refused by the method."""

    RIGHT = "right"
    REFUSED = "refused"
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class StressResult:
    """Result of a method on a stress test.

    `error` is the greatest of the errors of final and peak displacements, relative to the greatest
    peak, and of the time off the belt, relative to the duration; None if refused. `reason` says why
    the method refused, or what is wrong.
    """

    verdict: StressVerdict
    error: float | None = None
    reason: str = ""
    steps: int | None = None


@dataclass(frozen=True, slots=True)
class MethodUnderTest:
    """A method under test: its name, its greatest number of steps, and its kernel."""

    name: str
    max_steps: int
    kernel: KernelChoice = "auto"


METHODS_UNDER_TEST: Final[Mapping[str, MethodUnderTest]] = {
    "taylor": MethodUnderTest("taylor", 3_000_000),
    "taylor-interpreted": MethodUnderTest("taylor", 15_000, "interpreted"),
    "rk4": MethodUnderTest("rk4", 20_000),
    "scipy-dop853": MethodUnderTest("scipy-dop853", 8_000),
    "scipy-radau": MethodUnderTest("scipy-radau", 8_000),
    "scipy-lsoda": MethodUnderTest("scipy-lsoda", 25_000),
    "fmu": MethodUnderTest("fmu", _PROGRESS_CALLS * _STEPS_PER_CALL),
}

_BASE_T_END: Final = 20.0
STRESS_TESTS: Final[Mapping[str, StressTest]] = {
    test.name: test
    for test in (
        StressTest("hard-cubic", "k_nl = 1e9 N/m³", Parameters(k_nl=1e9), 20.0),
        StressTest("hard-linear", "k2 = 1e8 N/m", Parameters(k2=1e8), 2.0),
        StressTest("light", "m = 1e-6 kg: stiff", Parameters(m=1e-6), 10.0),
        StressTest("heavy-load", "F = 1e6 N", Parameters(F=1e6), 20.0),
        StressTest("undamped", "no damping", Parameters(c1=0.0, c2=0.0), 20.0),
        StressTest("strong-friction", "μ = 5: unbounded growth", Parameters(mu=5.0), 12.0),
        StressTest("rest-on-switch", "F = 0: rests exactly on the switch", Parameters(F=0.0), 20.0),
        StressTest(
            "start-on-switch",
            "F = 0, starts at y = ẏ = 0",
            Parameters(F=0.0),
            20.0,
            start=(0.5, 0.0, 0.0, 0.0),
        ),
        StressTest("start-at-origin", "starts at y = ẏ = 0", Parameters(), 20.0, start=(0.0,) * 4),
        StressTest(
            "lifted",
            "F = -20 N: leaves the belt for good",
            Parameters(F=-20.0),
            20.0,
            start=(0.1, 0.0, -0.2, 1.0),
        ),
        StressTest("long", "a run of 1e5 s", Parameters(), 1e5),
        StressTest(
            "linear-growth",
            "k_nl = 0, contact never breaks: overflow",
            Parameters(k2=186.0, k_nl=0.0, mu=2.0),
            1e4,
            separation=False,
            has_result=False,
        ),
        StressTest("base", "base scene, tol 1e-9", Parameters(), _BASE_T_END),
        *(
            StressTest(
                f"tol-{tol:g}",
                f"base scene, tol {tol:g}",
                Parameters(),
                _BASE_T_END,
                tol,
                same_result_as="base",
            )
            for tol in (1e-3, 1e-6, 1e-13)
        ),
        StressTest(
            "tol-too-small",
            "tol 1e-16, below rounding",
            Parameters(),
            _BASE_T_END,
            1e-16,
            same_result_as="base",
        ),
    )
}


@cache
def _true_results() -> Mapping[str, TrueResult]:
    text = files(__package__).joinpath(TRUTH_FILE).read_text(encoding="utf-8")
    results = {}
    for name, entry in json.loads(text).items():
        separations = int(entry.pop("separations"))
        numbers = {key: float(value) for key, value in entry.items()}
        results[name] = TrueResult(separations=separations, **numbers)
    return results


def true_result(test: StressTest) -> TrueResult | None:
    """The true result of a test; None if no finite result exists."""
    return _true_results()[test.same_result_as or test.name] if test.has_result else None


def run_stress_test(test: StressTest, method: MethodUnderTest) -> StressResult:
    """Run one method on one test."""
    calls = itertools.count(1)

    def continue_fmu(_fraction: float) -> bool:
        return next(calls) <= _PROGRESS_CALLS

    try:
        run = simulate(
            test.parameters,
            t_end=test.t_end,
            tol=test.tol,
            separation=test.separation,
            start=test.start,
            method=method.name,
            max_steps=method.max_steps,
            kernel=method.kernel,
            progress=continue_fmu if method.name == "fmu" else None,
        )
    except Cancelled:
        return StressResult(
            StressVerdict.REFUSED, reason=f"over {method.max_steps} communication steps"
        )
    except ComputationError as error:
        return StressResult(StressVerdict.REFUSED, reason=error.why)
    except InputError as error:
        return StressResult(StressVerdict.REFUSED, reason=str(error))
    return _judge(run, test)


def _judge(run: Transient, test: StressTest) -> StressResult:
    # Compare a finished run with the true result.
    expected = true_result(test)
    if expected is None:
        return StressResult(
            StressVerdict.WRONG, reason="no finite answer exists", steps=run.stats.steps
        )
    greatest_peak = max(expected.x_abs, expected.y_abs) or 1.0
    differences = (
        run.final.x - expected.x,
        run.final.y - expected.y,
        run.peak.x_abs - expected.x_abs,
        run.peak.y_abs - expected.y_abs,
    )
    error = max(
        max(map(abs, differences)) / greatest_peak,
        abs(run.events.separated_time - expected.separated_time) / test.t_end,
    )
    reason = ""
    if run.events.separations != expected.separations:
        reason = f"{run.events.separations} separations, not {expected.separations}"
    is_right = not reason and error <= max(_ERROR_LIMIT, _TOL_MULTIPLE * test.tol)
    verdict = StressVerdict.RIGHT if is_right else StressVerdict.WRONG
    return StressResult(verdict, error, reason, run.stats.steps)


def run_stress_tests(
    tests: Sequence[str] = tuple(STRESS_TESTS),
    methods: Sequence[str] = tuple(METHODS_UNDER_TEST),
    *,
    progress: OnProgress | None = None,
) -> dict[str, dict[str, StressResult]]:
    """Run methods on stress tests; results by test and method."""
    _check_names("stress test", tests, STRESS_TESTS)
    _check_names("method", methods, METHODS_UNDER_TEST)
    results: dict[str, dict[str, StressResult]] = {name: {} for name in tests}
    pairs = [(test, method) for test in tests for method in methods]
    work = Progress(progress)
    for count, (test, method) in enumerate(pairs):
        work.report(count / len(pairs))
        results[test][method] = run_stress_test(STRESS_TESTS[test], METHODS_UNDER_TEST[method])
    work.advance(1.0)
    return results


def _check_names(kind: str, names: Sequence[str], allowed: Mapping[str, object]) -> None:
    for name in names:
        check_known(kind, name, allowed)


def stress_tests_to_dict(tests: Mapping[str, Mapping[str, StressResult]]) -> dict[str, object]:
    """Results of `run_stress_tests` as JSON data.

    The one key is ``trials``, a list of the tests. Each has its scene and, as ``findings``, its
    results by method.
    """
    rows = []
    for name, results in tests.items():
        test = STRESS_TESTS[name]
        rows.append(
            {
                "name": name,
                "meaning": test.meaning,
                "parameters": test.parameters.as_dict(),
                "separation": test.separation,
                "start": test.start if isinstance(test.start, str) else list(test.start),
                "t_end": test.t_end,
                "tol": test.tol,
                "findings": {method: asdict(result) for method, result in results.items()},
            }
        )
    return {"trials": rows}

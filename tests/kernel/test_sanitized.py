"""Nothing undefined happens in the kernel: random problems under gcc's sanitizers."""

import os
import select
import shutil
import struct
import subprocess
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import fivtui
from fivtui.kernel.field_text import equation_headers
from fivtui.model import Parameters

KERNEL = Path(fivtui.__file__).parent / "kernel"
COMPILER_OPTIONS = ("-std=c11", "-O1", "-g1", "-march=native", "-Wno-psabi", "-fno-strict-aliasing")
SANITIZER_OPTIONS = (
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-ffp-contract=off",
)
# Time limit in s; a normal problem takes milliseconds.
TIME_LIMIT: Final = 60.0


@dataclass(frozen=True)
class Problem:
    """A problem for `problems.c`: counts, capacities for results, and options."""

    order: int
    members: int
    # Flags of a batch: whether all contact springs are cubic; whether extremes of y, all extremes,
    # and those of y in the second half of the run are found.
    cubic: int
    amplitude: int
    peak: int
    steady: int
    # Steps of one call; capacities of its buffers, of which that for segments is absent below 0.
    budget: int
    switches: int
    times: int
    segments: int
    # Directions in which start and parameters change, for derivatives.
    seeds: int
    # Capacity for switches at y = 0, which a run with derivatives stores with these.
    crossings: int
    t_end: float
    tol: float
    max_steps: float


@dataclass(frozen=True)
class Numbers:
    """Arrays of a problem; rows are repeated up to the counts of the problem."""

    parameters: list[list[float]]
    starts: list[list[float]]
    separation: list[bool]
    times: list[float]
    seeds: list[list[float]]


class SanitizedKernel:
    """The kernel under the sanitizers; its process is restarted after a crash."""

    def __init__(self, program: Path) -> None:
        self._program = program
        self._process: subprocess.Popen[bytes] | None = None

    def solve(self, problem: Problem, numbers: Numbers) -> None:
        """Solve a problem; raises `AssertionError` with the sanitizer's report on a defect."""
        process = self._running_process()
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(pack(problem, numbers))
            process.stdin.flush()
        except BrokenPipeError:
            pass
        ready, _, _ = select.select([process.stdout], [], [], TIME_LIMIT)
        if not ready:
            self.close()
            raise AssertionError("the kernel hangs")
        if process.stdout.read(1) != b".":
            assert process.stderr is not None
            report = process.stderr.read().decode(errors="replace")
            self.close()
            raise AssertionError(report)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def _running_process(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            self._process = subprocess.Popen(
                [str(self._program)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=os.environ | {"ASAN_OPTIONS": "detect_leaks=0"},
            )
        return self._process


def pack(problem: Problem, numbers: Numbers) -> bytes:
    """The bytes that `problems.c` reads."""
    kinds = "".join("q" if field.type is int else "d" for field in fields(Problem))

    def rows(values: list[list[float]], count: int, width: int) -> bytes:
        return np.resize(np.array(values, dtype=float), (count, width)).tobytes()

    separation = np.resize(np.array(numbers.separation, dtype=np.uint8), problem.members)
    return b"".join(
        [
            struct.pack(f"={kinds}", *astuple(problem)),
            rows(numbers.parameters, problem.members, len(BASE)),
            rows(numbers.starts, problem.members, STATE_SIZE),
            separation.tobytes(),
            np.array(numbers.times, dtype=float).tobytes(),
            rows(numbers.seeds, problem.seeds, SEED_SIZE),
        ]
    )


ARBITRARY_NUMBERS = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 5e-324, -1e-300, 1e15, 1e300, -1.7e308]),
    st.sampled_from([float("inf"), float("-inf"), float("nan")]),
    st.floats(),
)


def mostly_usual(usual: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    """Usual numbers, sometimes arbitrary ones."""
    return st.integers(0, 9).flatmap(lambda chance: ARBITRARY_NUMBERS if chance == 0 else usual)


STATE_SIZE = 4
BASE = list(Parameters().values())
# A seed has the derivatives of a state and of the parameters.
SEED_SIZE = STATE_SIZE + len(BASE)
PARAMETERS = st.tuples(*(mostly_usual(st.floats(0.0, 2.0 * value)) for value in BASE)).map(list)
STARTS = st.lists(
    mostly_usual(st.one_of(st.just(0.0), st.floats(-2.0, 2.0))),
    min_size=STATE_SIZE,
    max_size=STATE_SIZE,
)
SEEDS = st.lists(mostly_usual(st.floats(-1.0, 1.0)), min_size=SEED_SIZE, max_size=SEED_SIZE)


@st.composite
def problems(draw: st.DrawFn) -> tuple[Problem, Numbers]:
    """Problems with arbitrary inputs and with capacities from zero."""
    flag = st.integers(0, 1)
    times = draw(
        st.lists(mostly_usual(st.floats(0.0, 2.0)), max_size=5).map(sorted)
        | st.lists(ARBITRARY_NUMBERS)
    )
    problem = Problem(
        order=draw(st.sampled_from([8, 12, 16, 20])),
        members=draw(st.one_of(st.integers(0, 3), st.integers(0, 120))),
        cubic=draw(flag),
        amplitude=draw(flag),
        peak=draw(flag),
        steady=draw(flag),
        budget=draw(st.integers(-1, 40)),
        switches=draw(st.integers(0, 3)),
        times=len(times),
        segments=draw(st.integers(-1, 3)),
        seeds=draw(st.integers(1, 16)),
        crossings=draw(st.integers(0, 3)),
        t_end=draw(mostly_usual(st.floats(1e-3, 5.0))),
        tol=draw(mostly_usual(st.floats(-16.0, -2.0).map(lambda exponent: 10.0**exponent))),
        max_steps=draw(mostly_usual(st.floats(1.0, 500.0))),
    )
    numbers = Numbers(
        draw(st.lists(PARAMETERS, min_size=1, max_size=4)),
        draw(st.lists(STARTS, min_size=1, max_size=4)),
        draw(st.lists(st.booleans(), min_size=1, max_size=4)),
        times,
        draw(st.lists(SEEDS, min_size=1, max_size=3)),
    )
    return problem, numbers


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SanitizedKernel]:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    folder = tmp_path_factory.mktemp("sanitized")
    program = folder / "problems"
    for name, text in equation_headers().items():
        (folder / name).write_text(text, encoding="utf-8")
    # `lanes` and `belt_lanes` compute batches side by side in SIMD vectors, without and with a
    # finite speed of the belt.
    units = [
        str(KERNEL / f"{unit}.c")
        for unit in ("single", "belt", "vary", "orbit", "lanes", "belt_lanes")
    ]
    driver = str(Path(__file__).with_name("problems.c"))
    compilation = subprocess.run(
        [
            "gcc",
            *COMPILER_OPTIONS,
            *SANITIZER_OPTIONS,
            f"-I{KERNEL}",
            f"-I{folder}",
            *units,
            driver,
            "-o",
            str(program),
            "-lm",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    if compilation.returncode != 0 and "sanitize" in compilation.stderr:
        pytest.skip("gcc has no sanitizers here")
    assert compilation.returncode == 0, compilation.stderr
    kernel = SanitizedKernel(program)
    yield kernel
    kernel.close()


@pytest.mark.whole
@pytest.mark.host
@settings(max_examples=1500, deadline=None, suppress_health_check=list(HealthCheck))
@given(problems())
def test_nothing_undefined_happens_in_any_problem(
    sanitized: SanitizedKernel, problem: tuple[Problem, Numbers]
) -> None:
    sanitized.solve(*problem)


@pytest.mark.whole
@pytest.mark.host
def test_the_sanitizers_detect_a_buffer_that_is_too_small(sanitized: SanitizedKernel) -> None:
    numbers = Numbers([BASE], [[0.0] * STATE_SIZE], [True], [], [[0.0] * SEED_SIZE])
    valid_problem = Problem(20, 1, 1, 1, 1, 1, 9, 1, 0, 0, 1, 1, 1.0, 1e-15, 100.0)
    sanitized.solve(valid_problem, numbers)
    # A run has buffers for the derivatives of at most sixteen seeds.
    with pytest.raises(AssertionError, match=r"runtime error|AddressSanitizer"):
        sanitized.solve(Problem(**{**vars(valid_problem), "seeds": 18}), numbers)

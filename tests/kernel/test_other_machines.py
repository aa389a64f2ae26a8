"""The kernel, cross-compiled and run in an emulator, gives the bits of this machine.

A driven run has parameters over time: a course, given as a table. A batch computes its members
side by side.
"""

import os
import shutil
import struct
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import fivtui
from fivtui.kernel import Kernel, Status, load_kernel
from fivtui.kernel.field_text import FLAGS, equation_headers
from fivtui.kernel.runs import CourseTable
from fivtui.model import PARAMETERS

from .test_same_bits import (
    ALL_EXTREMES,
    COLUMNS,
    K_NL,
    LOAD,
    MU,
    Members,
    assert_same_bits,
    batch_results,
    random_members,
    single_runs,
    suitable_tolerance,
)

HERE = Path(__file__).parent
KERNEL = Path(fivtui.__file__).parent / "kernel"
# Programs that run the code of a machine, by the compiler's name of the machine.
EMULATORS = {
    "aarch64-linux-musl": ("qemu-aarch64-static", "qemu-aarch64"),
    "x86_64-windows-gnu": ("wine",),
}
T_END, ORDER = 20.0, 20
# Load that scales displacements in driven runs, N, as in outcomes.c.
GREATEST_LOAD = 80.0


def compile_for(target: str, folder: Path) -> Path:
    program = folder / ("results.exe" if "windows" in target else "results")
    environment = dict(os.environ)
    for cache in ("GLOBAL", "LOCAL"):
        environment.setdefault(f"ZIG_{cache}_CACHE_DIR", str(folder))
    flags = [flag for flag in FLAGS if flag != "-fPIC"]
    units = [KERNEL / f"{unit}.c" for unit in ("single", "belt", "lanes")]
    sources = [str(HERE / "outcomes.c"), *map(str, units)]
    for name, text in equation_headers().items():
        (folder / name).write_text(text, encoding="utf-8")
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target, f"-I{folder}", f"-I{KERNEL}"]
    subprocess.run([*zig, *flags, "-o", str(program), *sources], check=True, env=environment)
    return program


def random_belts(parameters: np.ndarray) -> tuple[np.ndarray, list[CourseTable]]:
    """Parameters with a belt of finite speed, and a table over time, for each member."""
    rng, count = np.random.default_rng(3), len(parameters)
    speeds = rng.choice([0.0, 1.0], count) * rng.uniform(0.0, 3.0, count)
    mu_static = parameters[:, MU] + rng.choice([0.0, 0.3], count)
    v_s = np.where(rng.random(count) < 0.5, 0.0, rng.uniform(0.1, 1.0, count))
    tables = []
    for member, (speed, mu_s) in enumerate(zip(speeds, mu_static, strict=True)):
        load, mu = parameters[member, LOAD], parameters[member, MU]
        slopes = rng.uniform(-1.0, 1.0, 2)
        # Value and slope of F, μ, μ_s and v_belt; v_belt just before the next row, where it jumps.
        speed_before = speed + slopes[1]
        inputs = [load, slopes[0], mu, 0.0, mu_s, 0.0, speed, abs(slopes[1]), speed_before]
        # Then the parameters, and two columns that the kernel writes.
        row = [*inputs, *parameters[member].tolist(), 0.0, 0.0]
        rows = [[0.4 * T_END * n, *row] for n in range(3)]
        tables.append(CourseTable(np.array(rows), GREATEST_LOAD))
    return np.column_stack([parameters, speeds, mu_static, v_s]), tables


def belt_results(
    kernel: Kernel, inputs: Members, belts: np.ndarray, tables: list[CourseTable], driven: bool
) -> np.ndarray:
    _, separation, starts = inputs
    rows = np.empty((len(belts), COLUMNS))
    for member, row in enumerate(belts.tolist()):
        # As in outcomes.c: some driven runs are on a belt that is always faster.
        has_finite_belt = not driven or member % 4 > 0
        run = kernel.begin_run(
            row[: len(PARAMETERS)],
            starts[member].tolist(),
            separation=bool(separation[member]),
            t_end=T_END,
            tol=suitable_tolerance(ORDER),
            order=ORDER,
            belt=tuple(row[len(PARAMETERS) :]) if has_finite_belt else None,
            table=tables[member] if driven else None,
        )
        while run.advance(701) is Status.RUNNING:
            pass
        rows[member] = run.outcome
    return rows


def emulated_results(
    runner: str, program: Path, inputs: Members, has_cubic_spring: bool, belt_bytes: bytes
) -> tuple[np.ndarray, ...]:
    parameters, separation, starts = inputs
    head = struct.pack(
        "3q2d", len(parameters), ORDER, has_cubic_spring, T_END, suitable_tolerance(ORDER)
    )
    request_file, result_file = program.parent / "request", program.parent / "results.bin"
    parts = [parameters.tobytes(), starts.tobytes(), separation.astype(np.uint8).tobytes()]
    request_file.write_bytes(head + b"".join([*parts, belt_bytes]))
    command = [runner, str(program), request_file.name, result_file.name]
    subprocess.run(command, check=True, cwd=program.parent)
    return tuple(np.fromfile(result_file).reshape(4, len(parameters), COLUMNS))


@pytest.mark.whole
@pytest.mark.host
@pytest.mark.skipif(find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)")
@pytest.mark.parametrize("target", list(EMULATORS))
def test_another_machine_gives_the_same_bits(target: str, tmp_path: Path) -> None:
    runner = next(filter(None, map(shutil.which, EMULATORS[target])), None)
    if runner is None:
        pytest.skip(f"not installed: {', '.join(EMULATORS[target])}")
    program = compile_for(target, tmp_path)
    kernel, inputs_of_all = load_kernel(), random_members(1000, 16)
    for has_cubic_spring in (True, False):
        selected = (inputs_of_all[0][:, K_NL] > 0.0) == has_cubic_spring
        inputs = (
            inputs_of_all[0][selected],
            inputs_of_all[1][selected],
            inputs_of_all[2][selected],
        )
        belts, tables = random_belts(inputs[0])
        table_rows = np.array([table.rows for table in tables])
        packed_belts = belts.tobytes() + table_rows.tobytes()
        single, belt, driven, batch = emulated_results(
            runner, program, inputs, has_cubic_spring, packed_belts
        )
        for emulated_rows, is_driven in ((belt, False), (driven, True)):
            assert_same_bits(emulated_rows, belt_results(kernel, inputs, belts, tables, is_driven))
        expected = single_runs(kernel, inputs, T_END, ORDER)
        assert_same_bits(single, expected)
        assert_same_bits(batch, expected)
        assert_same_bits(batch, batch_results(kernel, inputs, T_END, ORDER, ALL_EXTREMES))

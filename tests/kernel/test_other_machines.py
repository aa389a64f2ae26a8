"""The kernel, cross-compiled and run in an emulator, gives the bits of this machine."""

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
from fivtui.kernel.field_text import FLAGS
from fivtui.kernel.over_time import CourseTable

from .test_same_bits import COLUMNS, Members, alone, assert_same, in_lanes, members

HERE = Path(__file__).parent
KERNEL = Path(fivtui.__file__).parent / "kernel"
EVERYTHING = (True, True, True)
# Emulator of each machine, by the compiler's name of the machine.
STAND_INS = {
    "aarch64-linux-musl": ("qemu-aarch64-static", "qemu-aarch64"),
    "x86_64-windows-gnu": ("wine",),
}
T_END, ORDER = 20.0, 20


def compiled_for(target: str, folder: Path) -> Path:
    program = folder / ("outcomes.exe" if "windows" in target else "outcomes")
    environment = dict(os.environ)
    for cache in ("GLOBAL", "LOCAL"):
        environment.setdefault(f"ZIG_{cache}_CACHE_DIR", str(folder))
    flags = [flag for flag in FLAGS if flag != "-fPIC"]
    units = [KERNEL / f"{unit}.c" for unit in ("single", "belt", "lanes")]
    sources = [str(HERE / "outcomes.c"), *map(str, units)]
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target]
    subprocess.run([*zig, *flags, "-o", str(program), *sources], check=True, env=environment)
    return program


def on_belts(parameters: np.ndarray) -> tuple[np.ndarray, list[CourseTable]]:
    """Parameters on belts of finite speed, and legs of tables, of each member."""
    rng, count = np.random.default_rng(3), len(parameters)
    speeds = rng.choice([0.0, 1.0], count) * rng.uniform(0.0, 3.0, count)
    static = parameters[:, 8] + rng.choice([0.0, 0.3], count)
    of_law = np.where(rng.random(count) < 0.5, 0.0, rng.uniform(0.1, 1.0, count))
    every = []
    for member, (speed, grip) in enumerate(zip(speeds, static, strict=True)):
        load, mu = parameters[member, 6], parameters[member, 8]
        change = rng.uniform(-1.0, 1.0, 2)
        row = [load, change[0], mu, 0.0, grip, 0.0, speed, abs(change[1]), speed + change[1]]
        rows = [[0.4 * T_END * n, *row] for n in range(3)]
        every.append(CourseTable(np.array(rows), 80.0))
    return np.column_stack([parameters, speeds, static, of_law]), every


def expected_on_belts(
    kernel: Kernel, inputs: Members, belts: np.ndarray, every: list[CourseTable], driven: bool
) -> np.ndarray:
    _, separation, starts = inputs
    rows = np.empty((len(belts), COLUMNS))
    for member, row in enumerate(belts.tolist()):
        run = kernel.begin_run(
            row[:9],
            starts[member].tolist(),
            separation=bool(separation[member]),
            t_end=T_END,
            tol=10.0 ** (-0.75 * ORDER),
            order=ORDER,
            belt=None if driven and member % 4 == 0 else (row[9], row[10], row[11]),
            table=every[member] if driven else None,
        )
        while run.advance(701) is Status.RUNNING:
            pass
        rows[member] = run.outcome
    return rows


def outcomes(
    runner: str, program: Path, inputs: Members, cubic: bool, on_belt: bytes
) -> tuple[np.ndarray, ...]:
    parameters, separation, starts = inputs
    head = struct.pack("3q2d", len(parameters), ORDER, cubic, T_END, 10.0 ** (-0.75 * ORDER))
    request_file, answered = program.parent / "asked", program.parent / "answered"
    parts = [parameters.tobytes(), starts.tobytes(), separation.astype(np.uint8).tobytes()]
    request_file.write_bytes(head + b"".join([*parts, on_belt]))
    command = [runner, str(program), request_file.name, answered.name]
    subprocess.run(command, check=True, cwd=program.parent)
    return tuple(np.fromfile(answered).reshape(4, len(parameters), COLUMNS))


@pytest.mark.whole
@pytest.mark.host
@pytest.mark.skipif(find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)")
@pytest.mark.parametrize("target", list(STAND_INS))
def test_another_machine_gives_the_same_bits(target: str, tmp_path: Path) -> None:
    runner = next(filter(None, map(shutil.which, STAND_INS[target])), None)
    if runner is None:
        pytest.skip(f"there is none of {', '.join(STAND_INS[target])}")
    program = compiled_for(target, tmp_path)
    kernel, everyone = load_kernel(), members(1000, 16)
    for cubic in (True, False):
        chosen = (everyone[0][:, 7] > 0.0) == cubic
        inputs = (everyone[0][chosen], everyone[1][chosen], everyone[2][chosen])
        belts, every = on_belts(inputs[0])
        legs = np.array([member_legs.rows for member_legs in every])
        packed = belts.tobytes() + legs.tobytes()
        single, belt, driven, lanes = outcomes(runner, program, inputs, cubic, packed)
        for expected_rows, moves in ((belt, False), (driven, True)):
            assert_same(expected_rows, expected_on_belts(kernel, inputs, belts, every, moves))
        expected = alone(kernel, inputs, T_END, ORDER)
        assert_same(single, expected)
        assert_same(lanes, expected)
        assert_same(lanes, in_lanes(kernel, inputs, T_END, ORDER, EVERYTHING))

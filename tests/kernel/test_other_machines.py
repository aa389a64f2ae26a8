"""The kernel compiled for other machines, and run in their place, gives the bits of this one."""

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
import hatch_build
from fivtui.kernel import load_kernel

from .test_same_bits import COLUMNS, Members, alone, assert_same, in_lanes, members

HERE = Path(__file__).parent
KERNEL = Path(fivtui.__file__).parent / "kernel"
EVERYTHING = (True, True, True)
# What runs programs of a machine here, by the compiler's name of that machine.
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
    flags = [flag for flag in hatch_build._FLAGS if flag != "-fPIC"]
    sources = [str(HERE / "outcomes.c"), str(KERNEL / "single.c"), str(KERNEL / "lanes.c")]
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target]
    subprocess.run([*zig, *flags, "-o", str(program), *sources], check=True, env=environment)
    return program


def outcomes(runner: str, program: Path, given: Members, cubic: bool) -> tuple[np.ndarray, ...]:
    parameters, separation, starts = given
    head = struct.pack("3q2d", len(parameters), ORDER, cubic, T_END, 10.0 ** (-0.75 * ORDER))
    asked, answered = program.parent / "asked", program.parent / "answered"
    parts = [parameters.tobytes(), starts.tobytes(), separation.astype(np.uint8).tobytes()]
    asked.write_bytes(head + b"".join(parts))
    command = [runner, str(program), asked.name, answered.name]
    subprocess.run(command, check=True, cwd=program.parent)
    single, lanes = np.fromfile(answered).reshape(2, len(parameters), COLUMNS)
    return single, lanes


@pytest.mark.whole
@pytest.mark.host
@pytest.mark.skipif(find_spec("ziglang") is None, reason="ziglang is not installed (extra cross)")
@pytest.mark.parametrize("target", list(STAND_INS))
def test_another_machine_gives_the_same_bits(target: str, tmp_path: Path) -> None:
    runner = next(filter(None, map(shutil.which, STAND_INS[target])), None)
    if runner is None:
        pytest.skip(f"there is none of {', '.join(STAND_INS[target])}")
    program = compiled_for(target, tmp_path)
    kernel, every = load_kernel(), members(1000, 16)
    for cubic in (True, False):
        some = (every[0][:, 7] > 0.0) == cubic
        given = (every[0][some], every[1][some], every[2][some])
        single, lanes = outcomes(runner, program, given, cubic)
        expected = alone(kernel, given, T_END, ORDER)
        assert_same(single, expected)
        assert_same(lanes, expected)
        assert_same(lanes, in_lanes(kernel, given, T_END, ORDER, EVERYTHING))

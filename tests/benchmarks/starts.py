"""How long a fresh process waits: for help, for a first run, for the compiled kernels."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import fivtui

ROOT = Path(fivtui.__file__).parents[1]


def _seconds(code: Sequence[str], cache: Path, repeats: int) -> float:
    environment = os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache)}
    least = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        subprocess.run([sys.executable, *code], env=environment, check=True, capture_output=True)
        least = min(least, time.perf_counter() - begin)
    return least


def starts(repeats: int = 3) -> list[tuple[str, float]]:
    """Wall-clock times of fresh processes, the least of some repeats, s."""
    first = "from fivtui import simulate; simulate()"
    compiled = "from fivtui import simulate; simulate(kernel='compiled')"
    linear = (
        "from fivtui import Parameters, simulate; simulate(Parameters(k_nl=0.0), separation=False)"
    )
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder)
        cold = _seconds(["-c", compiled], cache, 1)
        return [
            ("python -c pass", _seconds(["-c", "pass"], cache, repeats)),
            ("fivtui --help", _seconds(["-m", "fivtui", "--help"], cache, repeats)),
            ("first run, interpreted", _seconds(["-c", first], cache, repeats)),
            ("linear scene, exact", _seconds(["-c", linear], cache, repeats)),
            ("compiled kernels, cached", _seconds(["-c", compiled], cache, repeats)),
            ("compiled kernels, cold", cold),
        ]

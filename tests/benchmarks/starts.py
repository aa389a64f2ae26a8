"""How long a fresh process waits: for help, for a first run by each kernel."""

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import fivtui

ROOT = Path(fivtui.__file__).parents[1]


def _seconds(code: Sequence[str], repeats: int) -> float:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    least = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        subprocess.run([sys.executable, *code], env=environment, check=True, capture_output=True)
        least = min(least, time.perf_counter() - begin)
    return least


def starts(repeats: int = 3) -> list[tuple[str, float]]:
    """Wall-clock times of fresh processes, the least of some repeats, s."""
    first = "from fivtui import simulate; simulate(kernel={!r})"
    linear = (
        "from fivtui import Parameters, simulate; simulate(Parameters(k_nl=0.0), separation=False)"
    )
    return [
        ("python -c pass", _seconds(["-c", "pass"], repeats)),
        ("import of NumPy", _seconds(["-c", "import numpy"], repeats)),
        ("fivtui --help", _seconds(["-m", "fivtui", "--help"], repeats)),
        ("first run, interpreted", _seconds(["-c", first.format("interpreted")], repeats)),
        ("first run, compiled", _seconds(["-c", first.format("compiled")], repeats)),
        ("linear scene, exact", _seconds(["-c", linear], repeats)),
    ]

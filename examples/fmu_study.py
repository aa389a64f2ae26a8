"""A parameter study: fmpy runs the FMU for many preloads and stiffnesses, on all cores.

Run it as ``python examples/fmu_study.py``.
"""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

from fmu_src.build.builder import build_fmu


def peak(fmu: str, F: float, k_nl: float) -> tuple[float, float]:
    """Peak |y|, m, and number of separations within 50 s."""
    run = simulate_fmu(
        fmu,
        stop_time=50.0,
        output_interval=0.01,
        start_values={"F": F, "k_nl": k_nl},
        output=["y", "separations"],
    )
    return float(np.abs(run["y"]).max()), float(run["separations"][-1])


def main() -> None:
    """Print a row for each case."""
    cases = list(product((40.0, 80.0, 120.0), (50.0, 100.0)))
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor() as pool:
        fmu = str(build_fmu(Path(folder) / "slider_belt.fmu"))
        results = pool.map(peak, [fmu] * len(cases), *zip(*cases, strict=True))
        for (F, k_nl), (y, count) in zip(cases, results, strict=True):
            print(f"F {F:5.0f} N  k_nl {k_nl:4.0f} N/m^3  |y| {y:7.4f} m  separations {count:.0f}")


if __name__ == "__main__":
    main()

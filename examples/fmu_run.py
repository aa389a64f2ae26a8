"""The FMU in a script: build it, run it through fmpy in both cases, print the peaks.

Run it as ``python examples/fmu_run.py``.
"""

import tempfile
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

from fmu_src.build.builder import build_fmu


def main() -> None:
    """Print peaks of the base scene with separation considered and ignored."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = build_fmu(Path(folder) / "slider_belt.fmu")
        for separation in (True, False):
            result = simulate_fmu(
                str(fmu),
                stop_time=100.0,
                output_interval=0.01,
                start_values={"separation": separation, "F": 80.0, "k_nl": 100.0, "mu": 0.7},
                output=["y", "P", "separations"],
            )
            print(
                f"separation {'considered' if separation else 'ignored':10}"
                f"  peak |y| {np.abs(result['y']).max():.6f} m"
                f"  peak P {result['P'].max():7.1f} N"
                f"  separations {result['separations'][-1]:.0f}"
            )


if __name__ == "__main__":
    main()

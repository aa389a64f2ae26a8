"""Onset of squeal under a preload that is ramped up slowly, driven through fmpy.

Run it as ``python examples/fmu_ramp.py``.
"""

import tempfile
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

from fivtui import Parameters, stability
from fmu_src.build.builder import build_fmu

# Preload at the start, N, its rate, N/s, the end, s, and the friction coefficient.
FIRST, RATE, END, MU = 5.0, 0.25, 200.0, 0.5


def main() -> None:
    """Print where the equilibrium loses its stability and where the slider leaves the belt."""
    kinds = [("time", float), ("F", float), ("mu", float)]
    ramp = np.array([(0.0, FIRST, MU), (END, FIRST + RATE * END, MU)], dtype=kinds)
    with tempfile.TemporaryDirectory() as folder:
        run = simulate_fmu(
            str(build_fmu(Path(folder) / "slider_belt.fmu")),
            stop_time=END,
            output_interval=0.01,
            input=ramp,
            output=["F", "y", "separations", "last_event"],
        )
    sampled = run["F"][::20].tolist()
    critical = next(F for F in sampled if not stability(Parameters(F=F, mu=MU)).stable)
    print(f"the equilibrium loses its stability at F = {critical:.2f} N")
    first = run[np.argmax(run["separations"] > 0.0)]
    print(f"first separation at {first['last_event']:.3f} s, at F = {first['F']:.2f} N")
    print(f"separations until {END:.0f} s: {run['separations'][-1]:.0f}")


if __name__ == "__main__":
    main()

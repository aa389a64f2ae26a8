"""The base set scaled to a brake pad: another mass, length and time, the same dimensionless motion.

Run it as ``python examples/brake_scale.py``.
"""

import math
from dataclasses import replace

from fivtui import Parameters, simulate, stability

# A pad of 0.5 kg that is pressed with 10 kN and squeals at 2 kHz.
MASS, PRELOAD, FREQUENCY = 0.5, 10e3, 2e3


def scaled(p: Parameters, mass: float, length: float, time: float) -> Parameters:
    """The parameters of a model with its mass, lengths and times multiplied by factors."""
    return replace(
        p,
        m=p.m * mass,
        k1=p.k1 * mass / time**2,
        k2=p.k2 * mass / time**2,
        k3=p.k3 * mass / time**2,
        c1=p.c1 * mass / time,
        c2=p.c2 * mass / time,
        F=p.F * mass * length / time**2,
        k_nl=p.k_nl * mass / (length * time) ** 2,
    )


def main() -> None:
    """Print the parameters of the pad, and its motion beside that of the base set."""
    base = Parameters()
    mass = MASS / base.m
    time = max(value.imag for value in stability(base).eigenvalues) / (2.0 * math.pi * FREQUENCY)
    length = PRELOAD / base.F * time**2 / mass
    pad = scaled(base, mass, length, time)
    print(" ".join(f"--set {name}={value:.4g}" for name, value in pad.as_dict().items()))
    for p, length_unit, time_unit in ((base, 1.0, 1.0), (pad, length, time)):
        run = simulate(p, t_end=20.0 * time_unit)
        print(
            f"peak |y| {run.peak.y_abs:.4g} m, {run.peak.y_abs / length_unit:.9f} dimensionless, "
            f"{run.events.separations} separations, belt above {run.peak.vx_max:.4g} m/s"
        )


if __name__ == "__main__":
    main()

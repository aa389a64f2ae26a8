"""Make ``promise.json``: random scenes, quadruple-precision final states, and growth of errors.

The promise is the bound of errors that `docs/explanation/tolerance.md` gives for a tolerance;
`tests/transient/test_promise.py` checks it on these scenes. The bound depends on the growth of
errors and the number of fast periods.

Run it as ``python -m tests.references.make_promise``; it needs gcc and takes two minutes.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fivtui import Parameters, simulate
from fivtui.model import PARAMETERS, ComputationError, State, System, static_start, time_scale

from . import PROMISE_FILE

SOURCE = Path(__file__).with_name("quad.c")
COUNT = 400
SEED = 2026
# Scenes in which perturbations grow more than this are left out.
MAX_GROWTH = 300.0
# Number of equal intervals of a run, and the perturbation of a state relative to the scales of the
# run. Growth is measured from every end of an interval to every later one.
INTERVALS, PERTURBATION = 24, 1e-6
Floats = NDArray[np.float64]


def random_scene(rng: np.random.Generator) -> tuple[Parameters, bool, State, float]:
    """A random scene: masses, springs and lengths over orders of magnitude, in few digits."""
    is_wide = rng.random() < 0.5

    def number(low: float, high: float) -> float:
        return float(f"{math.exp(rng.uniform(math.log(low), math.log(high))):.4g}")

    def number_or_zero(zero_share: float, low: float, high: float) -> float:
        return 0.0 if rng.random() < zero_share else number(low, high)

    low, high = (1.0, 1e4) if is_wide else (10.0, 1000.0)
    m = number(0.01, 100.0) if is_wide else number(0.05, 50.0)
    k1, k2, k3 = number(low, high), number(low, high), number_or_zero(0.08, 0.01 * low, high)
    stiffness = k1 + k2 + k3
    c1, c2 = (number_or_zero(0.12, 2e-4, 0.6) * math.sqrt(k * m) for k in (k1, k2))
    force = number_or_zero(0.2, *((0.01, 1e4) if is_wide else (1.0, 300.0)))
    force = -force if rng.random() < 0.1 else force
    # A typical displacement, m, and the cubic part of the contact force at it, relative to k2's.
    size = number(1e-3, 10.0) if force == 0.0 else abs(force) / stiffness * number(0.1, 10.0)
    cubic_share = number_or_zero(0.15, 1e-3, 1e4 if is_wide else 3.0)
    k_nl = min(cubic_share * k2 / size**2, 1e15)
    rounded = [float(f"{value:.4g}") for value in (c1, c2, k_nl)]
    values = (m, k1, k2, k3, *rounded[:2], force, rounded[2], round(rng.uniform(0.0, 1.5), 3))
    p = Parameters(**dict(zip(PARAMETERS, values, strict=True)))
    separation = bool(rng.random() < 0.85)
    t_end = float(f"{rng.uniform(2.0, 60.0) * 2.0 * math.pi * time_scale(p):.4g}")

    def start_value(unit: float) -> float:
        if rng.random() < 0.2:
            return 0.0
        return float(f"{rng.normal() * 10.0 ** rng.uniform(-5.0, 0.0) * size * unit:.4g}")

    speed = 1.0 / time_scale(p)
    start = (start_value(1.0), start_value(speed), start_value(1.0), start_value(speed))
    if rng.random() < 0.2 and force > 0.0:
        start = static_start(System(p, separation))
    return p, separation, start, t_end


def final_state(p: Parameters, start: Floats, separation: bool, t_end: float) -> Floats:
    run = simulate(p, t_end=t_end, start=start.tolist(), separation=separation, tol=1e-12)
    return np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])


def scales(p: Parameters, start: State, separation: bool, t_end: float) -> Floats:
    """Scales of x, ẋ, y and ẏ: for x the greatest |x| or |ẋ|/ω, for ẋ ω times that; y alike."""
    run = simulate(p, t_end=t_end, start=start, separation=separation, samples=3000)
    assert run.trajectory is not None
    motion, omega = run.trajectory, 1.0 / time_scale(p)
    x = max(run.peak.x_abs, float(np.abs(motion.vx).max()) / omega)
    y = max(run.peak.y_abs, float(np.abs(motion.vy).max()) / omega)
    return np.array([x, x * omega, y, y * omega])


def growth(p: Parameters, start: State, separation: bool, t_end: float, units: Floats) -> float:
    """The largest growth factor of a perturbation between two times, in `units`."""
    state, interval_maps = np.array(start), []
    weights = np.where(units > 0.0, units, 1.0)
    for _ in range(INTERVALS):
        after = final_state(p, state, separation, t_end / INTERVALS)
        columns = []
        for index in range(4):
            perturbed = state.copy()
            perturbed[index] += PERTURBATION * weights[index]
            perturbation = (perturbed[index] - state[index]) / weights[index]
            columns.append(
                (final_state(p, perturbed, separation, t_end / INTERVALS) - after)
                / weights
                / perturbation
            )
        interval_maps.append(np.column_stack(columns))
        state = after
    largest = 1.0
    for first in range(INTERVALS):
        product = np.eye(4)
        for matrix in interval_maps[first:]:
            product = matrix @ product
            largest = max(largest, float(np.abs(product).sum(axis=1).max()))
    return largest


def main() -> None:
    rng = np.random.default_rng(SEED)
    entries: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "quad"
        command = ["gcc", "-O2", "-o", str(program), str(SOURCE), "-lquadmath", "-lm"]
        subprocess.run(command, check=True)
        while len(entries) < COUNT:
            p, separation, start, t_end = random_scene(rng)
            try:
                run = simulate(p, t_end=t_end, start=start, separation=separation, max_steps=3000)
                units = scales(p, start, separation, t_end)
                error_growth = growth(p, start, separation, t_end, units)
            except ComputationError:
                continue
            if not error_growth < MAX_GROWTH:
                continue
            arguments = [*p.values(), float(separation), t_end, *start]
            process = subprocess.run(
                [str(program)],
                input=" ".join(map(repr, map(float, arguments))),
                capture_output=True,
                text=True,
                check=True,
            )
            x, vx, y, vy, y_abs, x_abs, *_ = map(float, process.stdout.split())
            # The displacement in contact at which the contact spring is stiffest.
            stiffest_y = min(run.peak.y_min, 0.0) if separation else run.peak.y_abs
            fast_period = 2.0 * math.pi * time_scale(p, stiffest_y)
            entry = {
                "parameters": p.as_dict(),
                "separation": separation,
                "start": start,
                "t_end": t_end,
                "final": [x, vx, y, vy],
                "peaks": [x_abs, y_abs],
                "scales": [float(f"{unit:.3g}") for unit in units],
                "growth": float(f"{error_growth:.3g}"),
                "fast_periods": float(f"{t_end / fast_period:.3g}"),
            }
            entries.append(json.dumps(entry))
            print(len(entries), entry["growth"], entry["fast_periods"], file=sys.stderr, flush=True)
    text = "[\n" + ",\n".join(entries) + "\n]\n"
    Path(__file__).with_name(PROMISE_FILE).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()

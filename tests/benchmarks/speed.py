"""CPU time of typical computations: ``python -m tests.benchmarks.speed [--against FOLDER]``.

FOLDER is another checkout of fivtui. Both are measured alternately, each in a separate process, in
several rounds. The least time of each counts, and their ratio is printed.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, Literal

import click

ROOT: Final = Path(__file__).parents[2]
# Target duration of the repetitions within a round, s.
_ROUND_S: Final = 0.3


def workloads() -> dict[str, Callable[[], Any]]:
    """Workloads by name."""
    import numpy as np

    from fivtui import (
        Parameters,
        boundary,
        branch,
        find_scene,
        safe_friction,
        simulate,
        simulate_batch,
        stability_map,
    )

    # A scene has parameters, tables of those that change over time, and the horizon.
    base, stop = Parameters(), find_scene("brake-stop")
    tables = {"F": [(0.0, 20.0), (40.0, 100.0)], "mu": [(0.0, 0.2), (40.0, 0.7)]}
    law = {"v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}
    forces, wide = np.linspace(20.0, 140.0, 500), np.linspace(0.0, 150.0, 200)

    def over_time(kernel: Literal["compiled", "interpreted"]) -> Callable[[], Any]:
        return lambda: simulate(
            stop.parameters, over_time=dict(stop.over_time), t_end=stop.t_end, kernel=kernel
        )

    def batch(required: Any) -> Callable[[], Any]:
        return lambda: simulate_batch({"F": forces}, t_end=100.0, workers=1, require=required)

    return {
        "run, compiled": lambda: simulate(base, kernel="compiled"),
        "run, interpreted": lambda: simulate(base, t_end=20.0, kernel="interpreted"),
        "run, 10,000 samples": lambda: simulate(base, samples=10_000),
        "run, sensitivities": lambda: simulate(base, t_end=20.0, sensitivities=["mu", "F"]),
        "run on a slow belt": lambda: simulate(base.with_values({"v_belt": 0.2})),
        "run with a friction law": lambda: simulate(base.with_values(law)),
        "brake stop, compiled": over_time("compiled"),
        "brake stop, interpreted": over_time("interpreted"),
        "ramp of load and friction": lambda: simulate(base, over_time=tables, t_end=40.0),
        "run by rk4": lambda: simulate(base, t_end=5.0, method="rk4"),
        "run of the FMU": lambda: simulate(base, t_end=5.0, method="fmu"),
        "run of the native FMU": lambda: simulate(base, t_end=20.0, method="fmu-native"),
        "batch, final states": batch({"final"}),
        "batch, everything": batch({"final", "peak", "steady", "events"}),
        "map of the growth rate": lambda: stability_map(base, {"F": wide, "mu": wide / 100.0}),
        "branch through lift-off": lambda: branch(base, "mu", low=0.25, high=0.5),
        "folds over F and mu": lambda: boundary(
            base, "fold", {"F": (60.0, 150.0), "mu": (0.1, 0.6)}
        ),
        "safe friction": lambda: safe_friction(base),
    }


def least_times(name_part: str, seconds: float = _ROUND_S) -> dict[str, float]:
    """Least CPU time, s, of each workload whose name contains a text, after a warm-up run."""
    times = {}
    for name, run in workloads().items():
        if name_part not in name:
            continue
        run()
        least, spent = float("inf"), 0.0
        while spent <= seconds:
            begin = time.process_time()
            run()
            elapsed = time.process_time() - begin
            least, spent = min(least, elapsed), spent + max(elapsed, 1e-6)
        times[name] = least
    return times


def measure_checkout(root: Path, name_part: str) -> dict[str, float]:
    """Run this file on a checkout in a separate process and return its times."""
    code = (
        "import json, runpy, sys; measure = runpy.run_path(sys.argv[1])['least_times']; "
        "print(json.dumps(measure(sys.argv[2])))"
    )
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.run(
            [sys.executable, "-c", code, __file__, name_part],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(root)},
            check=True,
            stdout=subprocess.PIPE,
        )
    times: dict[str, float] = json.loads(process.stdout)
    return times


def start_time(root: Path, repeats: int = 5) -> float:
    """The least CPU time of a process that prints the program's help, s."""
    least = float("inf")
    for _ in range(repeats):
        begin = os.times().children_user
        subprocess.run(
            [sys.executable, "-m", "fivtui", "--help"],
            env=os.environ | {"PYTHONPATH": str(root)},
            check=True,
            capture_output=True,
        )
        least = min(least, os.times().children_user - begin)
    return least


def least_of(rounds: list[dict[str, float]]) -> Mapping[str, float]:
    """The least time of each workload in several rounds."""
    return {name: min(times[name] for times in rounds) for name in rounds[0]}


@click.command()
@click.option("--against", type=click.Path(path_type=Path), help="Another checkout of fivtui.")
@click.option("--only", default="", help="Measure only workloads whose name contains this text.")
@click.option("--rounds", default=3, show_default=True)
def main(against: Path | None, only: str, rounds: int) -> None:
    """Print the times, ms, and their ratios to those of another checkout."""
    roots = [ROOT] if against is None else [ROOT, against.resolve()]
    times_by_root: list[list[dict[str, float]]] = [[] for _ in roots]
    for _ in range(rounds):
        for root, times in zip(roots, times_by_root, strict=True):
            times.append({**measure_checkout(root, only), "start, help": start_time(root)})
    times_by_name, *baselines = map(least_of, times_by_root)
    for name, seconds in times_by_name.items():
        ratio = f"{seconds / baselines[0][name]:9.3f}" if baselines else ""
        print(f"{name:28}{1e3 * seconds:10.3f} ms{ratio}")


if __name__ == "__main__":
    main()

"""Costs of runs over tables by both kernels: ``python -m tests.benchmarks.over_time``."""

import time
from collections.abc import Iterator
from typing import Final, NamedTuple

from fivtui import Parameters, find_scene, simulate
from fivtui.transient import KernelChoice, Transient

_REPEATS: Final = 3
KERNELS: Final[tuple[KernelChoice, ...]] = ("interpreted", "compiled")


class Cost(NamedTuple):
    """The least CPU time of several runs of a scene, s, and what it came to."""

    scene: str
    kernel: str
    run: Transient
    seconds: float


def costs(t_end: float | None = None, repeats: int = _REPEATS) -> Iterator[Cost]:
    """Of a brake stop, and of a ramp on a belt that is always faster."""
    stop = find_scene("brake-stop")
    ramp = {"F": [(0.0, 20.0), (40.0, 100.0)], "mu": [(0.0, 0.2), (40.0, 0.7)]}
    scenes = (
        ("brake stop", stop.parameters, dict(stop.over_time), stop.t_end),
        ("ramp, belt always faster", Parameters(), ramp, 40.0),
    )
    for name, p, tables, until in scenes:
        for kernel in KERNELS:
            best = float("inf")
            for _ in range(repeats):
                begin = time.process_time()
                run = simulate(p, over_time=tables, t_end=t_end or until, kernel=kernel)
                best = min(best, time.process_time() - begin)
            yield Cost(name, kernel, run, best)


def main() -> None:
    """Print the table."""
    for cost in costs():
        per_step = 1e6 * cost.seconds / cost.run.stats.steps
        print(
            f"{cost.scene:26} {cost.kernel:12} {1e3 * cost.seconds:10.2f} ms "
            f"{cost.run.stats.steps:8} steps {per_step:8.2f} us a step"
        )


if __name__ == "__main__":
    main()

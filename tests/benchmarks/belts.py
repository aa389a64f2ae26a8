"""Cost of switches on belts of finite speed: ``python -m tests.benchmarks.belts``.

Costs are those of the base set without `v_belt` and with it, constant friction and the friction law
from μ_s on, all in turns in one run.
"""

import itertools
import time
from typing import Final, NamedTuple

from fivtui import Parameters, simulate

_SPEEDS: Final = (0.2, 1.0, 3.0, 10.0)
# None is constant friction.
_DECAYS: Final = (None, 0.1, 0.4, 1.0)
_STATIC: Final = 0.9
_TOLERANCES: Final = (1e-12, 1e-9, 1e-6)
_ROUNDS: Final = 25


class Cost(NamedTuple):
    """Of a scene with and without `v_belt`: least times of a run, s, its switches and steps."""

    v_belt: float | None
    v_s: float | None
    seconds: float
    switches: int
    steps: int

    def per_switch(self) -> float:
        """Time of a switch, s."""
        return self.seconds / self.switches


def scene(v_belt: float | None, v_s: float | None) -> Parameters:
    """The base set on a belt; always sliding without a speed."""
    return Parameters(v_belt=v_belt, v_s=v_s, mu_s=None if v_s is None else _STATIC)


def costs(tol: float, t_end: float = 100.0, rounds: int = _ROUNDS) -> list[Cost]:
    """Of all scenes, the first being that without `v_belt`; they run in turns."""
    keys = [(None, None), *itertools.product(_SPEEDS, _DECAYS)]
    best: dict[tuple[float | None, float | None], Cost] = {}
    for _ in range(rounds):
        for key in keys:
            p = scene(*key)
            begin = time.perf_counter()
            run = simulate(p, t_end=t_end, tol=tol)
            seconds = time.perf_counter() - begin
            events = run.events
            switches = sum(events.transitions.values())
            if key not in best or seconds < best[key].seconds:
                best[key] = Cost(*key, seconds, switches, run.stats.steps)
    return [best[key] for key in keys]


def main() -> None:
    """Print costs per switch as multiples of that without `v_belt`."""
    head = "".join(f"{'constant' if v_s is None else f'v_s {v_s:g}':>10}" for v_s in _DECAYS)
    print(f"time per switch over that without v_belt; mu_s {_STATIC:g} with v_s")
    for tol in _TOLERANCES:
        plain, *others = costs(tol)
        print(f"tol {tol:g}: {1e6 * plain.per_switch():.2f} us a switch without v_belt")
        print(f"{'v_belt (m/s)':14}{head}")
        for v_belt, row in itertools.groupby(others, lambda cost: cost.v_belt):
            ratios = "".join(f"{cost.per_switch() / plain.per_switch():10.2f}" for cost in row)
            print(f"{v_belt:<14g}{ratios}")


if __name__ == "__main__":
    main()

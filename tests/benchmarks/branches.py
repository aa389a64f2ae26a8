"""Cost of branches of limit cycles, beside a public package for continuation where it is installed.

Run ``python -m tests.benchmarks.branches``. The smooth branch is that of the base set with
separation ignored, from near the Hopf point through its fold; pycont-lite (``pip install
'.[peers]'``) follows the same equations of shooting by its own pseudo-arclength continuation, with
SciPy's integrator as its user would have it, and with the one of fivtui.
"""

import contextlib
import io
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Final

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fivtui import Parameters, boundary, branch, simulate
from fivtui.model.modes import Mode
from fivtui.model.slider_belt import accelerations
from fivtui.orbits import cycles_at

# The friction coefficient at which the smooth branch begins, its range, and its fold.
SMOOTH: Final = (0.41, 0.2, 0.5)
FOLD: Final = 0.3534474449
_REPEATS: Final = 5
Shooting = Callable[[np.ndarray[Any, Any], float], np.ndarray[Any, Any]]


@dataclass(frozen=True)
class Followed:
    """A branch followed: points, the fold or least parameter among them, and CPU time, s."""

    way: str
    points: int
    fold: float
    seconds: float


def timed(way: str, follow: Callable[[], tuple[int, float]], repeats: int = _REPEATS) -> Followed:
    """The least CPU time of several runs, after a first one."""
    points, fold = follow()
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        points, fold = follow()
        times.append(time.process_time() - begin)
    return Followed(way, points, fold, min(times, default=float("nan")))


def own(repeats: int = _REPEATS) -> list[Followed]:
    """Branches and a curve of folds by fivtui."""

    def along(separation: bool, low: float, high: float) -> tuple[int, float]:
        found = branch(None, "mu", low=low, high=high, separation=separation)
        folds = [event.value for event in found.events if event.kind.value == "fold"]
        return len(found.points), min(folds)

    def folds() -> tuple[int, float]:
        found = boundary(None, "fold", {"F": (60.0, 150.0), "mu": (0.1, 0.6)})
        return len(found.points), min(point.values[1] for point in found.points)

    _, low, high = SMOOTH
    return [
        timed("fivtui, through lift-off", lambda: along(True, 0.25, 0.5), repeats),
        timed("fivtui, separation ignored", lambda: along(False, low, high), repeats),
        timed("fivtui, folds over F and mu", folds, repeats),
    ]


def missing() -> str | None:
    """Why pycont-lite is not measured; None where it is."""
    if find_spec("pycont") is None:
        return "pycont-lite is not installed: pip install '.[peers]'"
    return None


def scipy_shooting(p: Parameters) -> Shooting:
    """How a motion from a lowest point misses it after a period, by SciPy's DOP853."""

    def miss(unknowns: np.ndarray[Any, Any], mu: float) -> np.ndarray[Any, Any]:
        at = p.with_values({"mu": float(mu)})

        def rate(_t: float, z: np.ndarray[Any, Any]) -> tuple[float, ...]:
            x, vx, y, vy = z.tolist()
            ax, ay = accelerations(at, (x, vx, y, vy), Mode.CONTACT)
            return (vx, ax, vy, ay)

        start = np.append(unknowns[:3], 0.0)
        run = solve_ivp(rate, (0.0, unknowns[3]), start, method="DOP853", rtol=1e-10, atol=1e-12)
        return np.asarray(run.y[:, -1] - start)

    return miss


def own_shooting(p: Parameters) -> Shooting:
    """The same by fivtui."""

    def miss(unknowns: np.ndarray[Any, Any], mu: float) -> np.ndarray[Any, Any]:
        start = np.append(unknowns[:3], 0.0)
        run = simulate(
            p.with_values({"mu": float(mu)}),
            t_end=float(unknowns[3]),
            start=start.tolist(),
            separation=False,
            tol=1e-12,
        )
        final = np.array([run.final.x, run.final.vx, run.final.y, run.final.vy])
        return np.asarray(final - start)

    return miss


def first_cycle(p: Parameters) -> np.ndarray[Any, Any]:
    """x, ẋ and y at the lowest point of a cycle near the Hopf point, and its period."""
    begin, low, high = SMOOTH
    found = branch(p, "mu", low=low, high=high, separation=False)
    cycle = cycles_at(found, begin)[0]
    run = simulate(
        p.with_values({"mu": begin}),
        t_end=2.0 * cycle.period,
        start=cycle.start,
        separation=False,
        samples="dense",
    )
    motion = run.solution
    assert motion is not None
    times = np.linspace(0.0, 2.0 * cycle.period, 201)
    place = 20 + int(motion(times[20:180]).y.argmin())
    lowest = brentq(lambda t: motion(np.array([t])).vy.item(), times[place - 1], times[place + 1])
    state = motion(np.array([lowest]))
    return np.array([state.x.item(), state.vx.item(), state.y.item(), cycle.period])


def pycont(way: str, shooting: Shooting, steps: int = 60) -> Followed:
    """The smooth branch by pycont-lite; its other searches are switched off."""
    from pycont import arclengthContinuation

    begin, low, high = SMOOTH
    options = {
        "hopf_detection": False,
        "analyze_stability": False,
        "bifurcation_detection": False,
        "param_min": low,
        "param_max": high,
        "initial_directions": "decrease_p",
        "tolerance": 1e-8,
    }
    start = first_cycle(Parameters())

    def follow() -> tuple[int, float]:
        with contextlib.redirect_stdout(io.StringIO()):
            found = arclengthContinuation(
                shooting, start, begin, 1e-6, 0.1, 0.02, steps, options, verbosity="off"
            )
        values = np.concatenate([each.p_path for each in found.branches])
        return values.size, float(values.min())

    began = time.process_time()
    points, least = follow()
    return Followed(way, points, least, time.process_time() - began)


def main() -> None:
    """Print what each way needs."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    rows = own()
    reason = missing()
    if reason is None:
        p = Parameters()
        rows.append(pycont("pycont-lite, flow by SciPy", scipy_shooting(p)))
        rows.append(pycont("pycont-lite, flow by fivtui", own_shooting(p)))
    else:
        print(f"not measured: {reason}")
    print(f"{'way':<32}{'points':>7}{'least mu':>14}{'CPU ms':>11}{'per point':>11}")
    for row in rows:
        each = 1e3 * row.seconds / row.points
        print(
            f"{row.way:<32}{row.points:>7}{row.fold:>14.8f}{1e3 * row.seconds:>11.2f}{each:>11.3f}"
        )
    print(f"The fold of the branch with separation ignored is at mu = {FOLD:.10f}.")


if __name__ == "__main__":
    main()

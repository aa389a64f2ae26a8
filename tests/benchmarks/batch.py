"""Cost of a sweep over the preload: batches, single runs, and heyoka where it is installed.

Run ``python -m tests.benchmarks.batch``. Every way computes the same 1000 base scenes of 100 s (the
slow ones a part of them) on one core; the errors are those of the worst member against a tolerance
of 1e-13, relative to the largest component of a state and to the peak.
"""

import importlib.util
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from fivtui import Parameters, simulate, simulate_batch
from fivtui.model import System
from fivtui.model.slider_belt import static_start

COUNT: Final = 1000
T_END: Final = 100.0
TOLERANCES: Final = (1e-4, 1e-8, 1e-12)
FORCES: Final = np.linspace(20.0, 140.0, COUNT)
REPEATS: Final = 3

# What a way finds for some preloads: final states, and peaks of |y| where it looks for them.
Found = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any] | None]


@dataclass(frozen=True)
class Way:
    """A way of computing the sweep.

    Attributes
    ----------
    name : str
        What it is called in the table.
    members : int
        How many members it is measured on.
    compute : callable
        (preloads, tol) to what it finds.
    """

    name: str
    members: int
    compute: Callable[[np.ndarray[Any, Any], float], Found]


def own_batch(*requirements: Any) -> Callable[[np.ndarray[Any, Any], float], Found]:
    """The batch with what is required, on one core."""

    def compute(forces: np.ndarray[Any, Any], tol: float) -> Found:
        batch = simulate_batch(
            {"F": forces}, t_end=T_END, tol=tol, workers=1, require={"final", *requirements}
        )
        if "peak" in requirements:
            return batch.final, batch.peak.y_abs
        return batch.final, batch.amplitude.y_abs if "amplitude" in requirements else None

    return compute


def own_single(forces: np.ndarray[Any, Any], tol: float) -> Found:
    """The compiled kernel, run after run."""
    runs = [simulate(Parameters(F=F), t_end=T_END, tol=tol, kernel="compiled") for F in forces]
    final = np.array([[r.final.x, r.final.vx, r.final.y, r.final.vy] for r in runs])
    return final, np.array([r.peak.y_abs for r in runs])


def _heyoka_system(hy: Any) -> Any:
    # Eqs. 1 to 4; the first parameter is 1 in contact and 0 off the belt, the second F.
    p = Parameters()
    x, vx, y, vy = hy.make_vars("x", "vx", "y", "vy")
    h = 0.5 * p.k3
    force = hy.par[0] * (-p.k2 * y - p.k_nl * y**3)
    return (y, vy), [
        (x, vx),
        (vx, (p.mu * force - p.c1 * vx - (p.k1 + h) * x + h * y) / p.m),
        (y, vy),
        (vy, (force - hy.par[1] - p.c2 * vy - h * y + h * x) / p.m),
    ]


def heyoka_single(*, peaks: bool) -> Callable[[np.ndarray[Any, Any], float], Found]:
    """heyoka's integrator: switches by a callback, peaks by events of ẏ."""
    import heyoka as hy

    (y, vy), system = _heyoka_system(hy)
    made: dict[float, Any] = {}
    seen = [0.0]

    def switch(ta: Any, sign: int) -> bool:
        ta.pars[0] = 1.0 if sign < 0 else 0.0
        return True

    def note(ta: Any, moment: float, _sign: int) -> None:
        seen[0] = max(seen[0], abs(ta.update_d_output(moment)[2]))

    def compute(forces: np.ndarray[Any, Any], tol: float) -> Found:
        if tol not in made:
            extremes = [hy.nt_event(vy, note)] if peaks else []
            made[tol] = hy.taylor_adaptive(
                system,
                [0.0] * 4,
                tol=tol,
                t_events=[hy.t_event(y, callback=switch)],
                nt_events=extremes,
            )
        ta = made[tol]
        final, greatest = [], []
        for force in forces:
            ta.time = 0.0
            ta.state[:] = static_start(System(Parameters(F=force)))
            ta.pars[:] = (1.0, force)
            ta.reset_cooldowns()
            seen[0] = abs(ta.state[2])
            ta.propagate_until(T_END)
            final.append(ta.state.copy())
            greatest.append(seen[0])
        return np.array(final), np.array(greatest) if peaks else None

    return compute


def heyoka_batch(*, peaks: bool) -> Callable[[np.ndarray[Any, Any], float], Found]:
    """heyoka's batch mode, as wide as the machine's vectors."""
    import heyoka as hy

    (y, vy), system = _heyoka_system(hy)
    width = hy.recommended_simd_size()
    made: dict[float, Any] = {}
    seen = np.zeros(width)

    def switch(ta: Any, sign: int, lane: int) -> bool:
        ta.pars[0, lane] = 1.0 if sign < 0 else 0.0
        return True

    def note(ta: Any, moment: float, _sign: int, lane: int) -> None:
        moments = np.array(ta.time)
        moments[lane] = moment
        seen[lane] = max(seen[lane], abs(ta.update_d_output(moments)[2, lane]))

    def compute(forces: np.ndarray[Any, Any], tol: float) -> Found:
        if tol not in made:
            extremes = [hy.nt_event_batch(vy, note)] if peaks else []
            made[tol] = hy.taylor_adaptive_batch(
                system,
                np.zeros((4, width)),
                tol=tol,
                pars=np.zeros((2, width)),
                t_events=[hy.t_event_batch(y, callback=switch)],
                nt_events=extremes,
            )
        ta = made[tol]
        final, greatest = [], []
        for first in range(0, len(forces), width):
            some = forces[first : first + width]
            ta.set_time(0.0)
            ta.state[:] = np.transpose(
                [static_start(System(Parameters(F=force))) for force in some]
            )
            ta.pars[:] = (np.ones(width), some)
            ta.reset_cooldowns()
            seen[:] = np.abs(ta.state[2])
            ta.propagate_until(T_END)
            final.append(ta.state.T.copy())
            greatest.append(seen.copy())
        return np.concatenate(final), np.concatenate(greatest) if peaks else None

    return compute


def ways() -> list[Way]:
    """All ways that can be had on this machine."""
    found = [
        Way("batch, final states", COUNT, own_batch()),
        Way("batch, final states and peaks", COUNT, own_batch("amplitude")),
        Way("batch, final states and all peaks", COUNT, own_batch("peak")),
        Way("batch, everything", COUNT, own_batch("peak", "steady", "events")),
        Way("single compiled runs, everything", 200, own_single),
    ]
    if importlib.util.find_spec("heyoka") is not None:
        found += [
            Way("heyoka, final states", 40, heyoka_single(peaks=False)),
            Way("heyoka, final states and peaks", 40, heyoka_single(peaks=True)),
            Way("heyoka batch, final states", 64, heyoka_batch(peaks=False)),
            Way("heyoka batch, final states and peaks", 64, heyoka_batch(peaks=True)),
        ]
    return found


def measure(way: Way, tol: float) -> tuple[float, float, float]:
    """CPU time of a member, s, and the worst errors of final states and peaks."""
    forces = FORCES[:: COUNT // way.members][: way.members]
    final, peaks = way.compute(forces, tol)
    seconds = []
    for _ in range(REPEATS):
        start = time.process_time()
        way.compute(forces, tol)
        seconds.append((time.process_time() - start) / way.members)
    exact = simulate_batch({"F": forces}, t_end=T_END, tol=1e-13, require={"final", "peak"})
    scale = np.abs(exact.final).max(axis=1)
    error = float((np.abs(final - exact.final).max(axis=1) / scale).max())
    if peaks is None:
        return min(seconds), error, float("nan")
    return min(seconds), error, float(np.abs(peaks / exact.peak.y_abs - 1.0).max())


def scaling() -> list[tuple[int, float]]:
    """Members a second of wall-clock time, by the number of workers up to that of processors."""
    forces = np.linspace(20.0, 140.0, 8 * COUNT)
    found = []
    for workers in range(1, (os.cpu_count() or 1) + 1):
        best = 0.0
        for _ in range(REPEATS):
            begin = time.perf_counter()
            simulate_batch({"F": forces}, t_end=T_END, workers=workers, require={"amplitude"})
            best = max(best, forces.size / (time.perf_counter() - begin))
        found.append((workers, best))
    return found


def main() -> None:
    """Print the tables."""
    print(f"sweep over F, base scene, {T_END:g} s, µs of CPU a run on one core; worst errors")
    print(f"{'':38} {'tol':>6} {'µs':>8} {'state':>9} {'peak':>9}")
    for tol in TOLERANCES:
        for way in ways():
            seconds, state, peak = measure(way, tol)
            shown = "" if np.isnan(peak) else f"{peak:.1e}"
            print(f"{way.name:38} {tol:6.0e} {seconds * 1e6:8.1f} {state:9.1e} {shown:>9}")
    print("workers, members a second, and how many times those of one worker")
    rates = scaling()
    for workers, rate in rates:
        print(f"{workers:7} {rate:12.0f} {rate / rates[0][1]:8.2f}")


if __name__ == "__main__":
    main()

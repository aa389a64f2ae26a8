"""Work-precision of single runs: CPU time against the error of the end state."""

import gc
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from fivtui.model import System
from fivtui.model.errors import ComputationError
from fivtui.transient.request import resolve_start
from tests.references import Reference

from .solvers import COMPILED, Solver

LEVELS: Final = tuple(10.0**-n for n in range(6, 12))


@dataclass(frozen=True)
class Measurement:
    """One solver at one setting.

    `error` is the greatest error of the final state relative to its greatest entry; `cpu_s` is the
    least CPU time of the repetitions.
    """

    solver: str
    setting: float
    error: float
    cpu_s: float


def measure(
    scene: Reference,
    solvers: Sequence[Solver],
    *,
    seconds: float = 0.3,
    rounds: int = 3,
    report: Callable[[str], object] = lambda _text: None,
) -> list[Measurement]:
    """Measure every solver at every setting.

    Every round measures all settings, so that a busy machine affects all of them alike.

    Parameters
    ----------
    scene : Reference
        A transient with a reference final state.
    solvers : sequence of Solver
        The solvers.
    seconds : float
        CPU time to spend on repetitions of one setting in a round, s.
    rounds : int
        Number of rounds.
    report : callable
        Receives progress messages.
    """
    start = resolve_start(System(scene.parameters, scene.separation), scene.start)
    size = max(map(abs, scene.final))
    cases = []
    for solver in solvers:
        report(f"preparing {solver.name}")
        for setting in solver.settings:
            run = solver.prepare(scene, start, setting)
            try:
                final = run()
            except (ComputationError, ArithmeticError, RuntimeError) as failure:
                report(f"{solver.name} at {setting:.3g}: {failure}")
                continue
            error = float(np.abs(np.subtract(final, scene.final)).max()) / size
            cases.append((solver.name, setting, error, run))
    best = [math.inf] * len(cases)
    for count in range(rounds):
        report(f"round {count + 1} of {rounds}")
        for index, (_, _, _, run) in enumerate(cases):
            best[index] = min(best[index], _measure_least_cpu(run, seconds))
    return [
        Measurement(name, setting, error, cpu)
        for (name, setting, error, _), cpu in zip(cases, best, strict=True)
    ]


def _measure_least_cpu(run: Callable[[], object], seconds: float) -> float:
    least, spent = math.inf, 0.0
    gc.disable()
    try:
        while spent <= seconds:
            begin = time.thread_time()
            run()
            elapsed = time.thread_time() - begin
            least, spent = min(least, elapsed), spent + max(elapsed, 1e-6)
    finally:
        gc.enable()
    return least


def cheapest(measurements: Sequence[Measurement], solver: str, level: float) -> float:
    """CPU time of the cheapest setting with an error of at most `level`, s; infinite if none.

    `solver` is a name, or the start of the names of several variants.
    """
    times = [m.cpu_s for m in measurements if m.solver.startswith(solver) and m.error <= level]
    return min(times, default=math.inf)


def ratio_to(
    measurements: Sequence[Measurement], solver: str, levels: Sequence[float] = LEVELS
) -> float | None:
    """CPU time of another solver over that of fivtui, at equal error.

    Geometric mean over the error levels that both reach; None if there is no such level.
    """
    logs = []
    for level in levels:
        ours, theirs = (
            cheapest(measurements, COMPILED, level),
            cheapest(measurements, solver, level),
        )
        if math.isfinite(ours) and math.isfinite(theirs):
            logs.append(math.log(theirs / ours))
    return math.exp(math.fsum(logs) / len(logs)) if logs else None


def table(measurements: Sequence[Measurement], levels: Sequence[float] = LEVELS) -> list[list[str]]:
    """Rows of name, CPU time in ms at every level, and ratio to fivtui compiled."""
    rows = []
    for solver in dict.fromkeys(m.solver for m in measurements):
        times = [cheapest(measurements, solver, level) for level in levels]
        ratio = ratio_to(measurements, solver, levels)
        cells = [f"{1e3 * t:.3g}" if math.isfinite(t) else "–" for t in times]
        rows.append([solver, *cells, f"{ratio:.2g}" if ratio else "–"])
    return rows


def draw(measurements: Sequence[Measurement], title: str, path: Path) -> None:
    """Draw error against CPU time."""
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    axes = figure.add_subplot()
    marks = "os^vDP*Xph<>"
    for mark, solver in zip(marks, dict.fromkeys(m.solver for m in measurements), strict=False):
        points = sorted(
            (m.cpu_s * 1e3, max(m.error, 1e-16)) for m in measurements if m.solver == solver
        )
        axes.loglog(*zip(*points, strict=True), mark, linestyle="-", ms=4, lw=0.8, label=solver)
    axes.set(
        xlabel="CPU time of one run, ms", ylabel="relative error of the end state", title=title
    )
    axes.grid(visible=True, which="major", lw=0.3)
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=150)

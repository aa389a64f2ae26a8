"""How fast the terminal UI answers: ``python -m tests.benchmarks.tui [--json]``.

Starts and keys are measured in a terminal of their own, the rest without one. What is shown is the
median, and the greatest of all in brackets.
"""

import argparse
import asyncio
import json
import random
import statistics
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from fivtui.simulation import simulate
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart.widget.chart_view import ChartView
from fivtui.tui.tabs.job_pane import JobPane
from tests.support.kernels import INTERPRETED

from .tui_terminal import LOADS, answers, starts

SIZE: Final = (100, 30)
SAMPLES: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class Measured:
    """Times of one thing, s, and the time that it may take."""

    what: str
    times: list[float]
    limit: float

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        median, worst = statistics.median(self.times), max(self.times)
        return {"what": self.what, "median_s": median, "worst_s": worst, "limit_s": self.limit}


def first_frame(repeats: int) -> list[Measured]:
    """From the start of a process to the first screen, and to the answer to a key pressed then."""
    found = []
    for columns, rows in ((80, 24), (200, 60)):
        started = starts(repeats, (columns, rows))
        size = f"{columns}x{rows}"
        found += [
            Measured(f"first screen at {size}", [start.shown for start in started], 1.0),
            Measured(f"… CPU time of it at {size}", [start.processor for start in started], 1.0),
            Measured(f"… first key there at {size}", [start.answered for start in started], 0.05),
        ]
    return found


def keys(repeats: int) -> list[Measured]:
    """From a key to what it changed on the screen, while something is computed."""
    return [
        Measured(f"key answered beside {load.what}", answers(load, repeats), 0.05) for load in LOADS
    ]


async def _timed(repeats: int, act: Callable[[], Awaitable[object]]) -> list[float]:
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        await act()
        times.append(time.perf_counter() - begin)
    return times


async def redraw(repeats: int) -> Measured:
    """The chart of y over time at a million samples: reduced, drawn, all lines rendered."""
    result = simulate(samples=np.linspace(0.0, 100.0, SAMPLES))
    app = FivtuiApp()
    async with app.run_test(size=SIZE) as pilot:
        run = app.session.runs.add_read(app.session.scene(), result, "benchmark")
        app.session.runs.displayed = run
        await pilot.press("alt+2")
        view = app.screen.query_one("#plot-y", ChartView)
        while view.chart is None:
            await pilot.pause(0.05)

        async def draw() -> None:
            view.redraw()
            for line in range(view.size.height):
                view.render_line(line)

        return Measured(
            f"redraw of a chart at {SAMPLES:,} samples", await _timed(repeats, draw), 0.05
        )


async def _stopped(app: FivtuiApp, group: str, stop: Callable[[], object]) -> float:
    # From the order to stop to the end of the thread.
    begin = time.perf_counter()
    stop()
    while any(worker.group == group for worker in app.workers if worker.is_running):
        await asyncio.sleep(0.001)
    return time.perf_counter() - begin


async def stop_run(repeats: int, what: str, fields: Mapping[str, str]) -> Measured:
    """Until the thread of a run has ended that was stopped at a time of chance."""
    chosen, times = random.Random(5), []
    app = FivtuiApp()
    async with app.run_test(size=SIZE) as pilot:
        for name, text in fields.items():
            app.session.set_text(name, text)
        for _ in range(repeats):
            await pilot.press("f5")
            while (active := app.session.runs.active) is not None and not active.fraction:
                await pilot.pause(0.02)
            await asyncio.sleep(chosen.uniform(0.1, 0.5))
            times.append(await _stopped(app, "transient", app.session.runs.stop))
    return Measured(f"stop of {what}", times, 0.1)


async def stop_job(repeats: int, what: str, key: str, fields: Mapping[str, str]) -> Measured:
    """Until the thread of a tab's job has ended that was stopped at a time of chance."""
    chosen, times = random.Random(5), []
    app = FivtuiApp()
    async with app.run_test(size=SIZE) as pilot:
        for name, text in fields.items():
            app.session.set_text(name, text)
        await pilot.press(key)
        await pilot.pause()
        pane = app.screen.query_one(JobPane)
        for _ in range(repeats):
            pane.stop()
            pane.work()
            await asyncio.sleep(chosen.uniform(0.2, 2.0))
            times.append(await _stopped(app, "job", pane.stop))
    return Measured(f"stop of {what}", times, 0.1)


async def _stops(repeats: int) -> list[Measured]:
    # The interpreted kernel holds the interpreter.
    with INTERPRETED:
        found = [await stop_run(repeats, "a run, interpreted", {"t_end": "1e6"})]
    return [
        *found,
        await stop_run(repeats, "a run, compiled", {"t_end": "1e7"}),
        await stop_run(repeats, "a run by rk4", {"t_end": "1e4", "method": "rk4"}),
        await stop_run(repeats, "a run of the FMU", {"t_end": "1e4", "method": "fmu"}),
        await stop_job(repeats, "a sweep", "alt+3", {"t_end": "1e5"}),
        await stop_job(repeats, "a trade-off", "alt+5", {"t_end": "1e3"}),
        await stop_job(repeats, "a check of the claims", "alt+6", {}),
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure how fast the terminal UI answers.")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--repeats", type=int, default=20)
    given = parser.parse_args()
    few = max(given.repeats // 4, 1)
    found = [
        *first_frame(few),
        *keys(given.repeats),
        asyncio.run(redraw(given.repeats)),
        *asyncio.run(_stops(few)),
    ]
    if given.json:
        print(json.dumps([measured.as_dict() for measured in found], indent=2))
        return
    for measured in found:
        row = measured.as_dict()
        times = f"{1e3 * row['median_s']:7.1f} ms ({1e3 * row['worst_s']:.1f})"
        print(f"{row['what']:45} {times:22} limit {1e3 * row['limit_s']:g} ms")


if __name__ == "__main__":
    main()

"""How fast the terminal UI answers: ``python -m tests.benchmarks.tui [--json]``.

Measured without a terminal: the time of the terminal itself comes on top. What is shown is the
median, and the greatest of all in brackets.
"""

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from unittest import mock

import numpy as np
from textual.events import Key
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.core import compiled
from fivtui.core.kernel_loader import KernelLoader
from fivtui.simulation import simulate
from fivtui.tui.app import FivtuiApp
from fivtui.tui.chart_view import ChartView
from fivtui.tui.form import FieldRow
from fivtui.tui.session import Session
from fivtui.tui.start import answer_quickly

SIZE: Final = (100, 30)
SAMPLES: Final = 1_000_000
_FIRST_FRAME: Final = """
import asyncio, time
from fivtui.tui.app import FivtuiApp
async def main():
    async with FivtuiApp().run_test(size=(100, 30)) as pilot:
        await pilot.pause()
        print(time.process_time(), flush=True)
asyncio.run(main())
"""


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
    """From the start of a process to the first frame."""
    times, processor = [], []
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    for _ in range(repeats):
        begin = time.perf_counter()
        command = [sys.executable, "-c", _FIRST_FRAME]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as child:
            assert child.stdout is not None
            processor.append(float(child.stdout.readline()))
            times.append(time.perf_counter() - begin)
    return [
        Measured("first frame", times, 1.0),
        Measured("first frame, CPU time", processor, 1.0),
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
        run = app.session.runs.take_in(app.session.scene(), result, "benchmark")
        app.session.runs.shown = run
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


async def _latency(pilot: Pilot[None], session: Session, repeats: int) -> list[float]:
    editor = pilot.app.screen.query_one("#row-F", FieldRow).query_one(Input)
    editor.focus()
    await pilot.pause()

    async def press() -> None:
        before = session.texts["F"]
        pilot.app.post_message(Key("up", None))
        while session.texts["F"] == before:
            await asyncio.sleep(0)
        while editor.value == before:
            await asyncio.sleep(0)

    return await _timed(repeats, press)


async def keys(repeats: int, *, running: bool) -> list[Measured]:
    """From a key to the changed field, and from the order to stop to the end of the thread."""
    answer_quickly()
    app = FivtuiApp()
    stops: list[float] = []
    async with app.run_test(size=SIZE) as pilot:
        if running:
            app.session.set_text("t_end", "1e6")
            await pilot.press("f5")
            active = app.session.runs.active
            while active is None or not active.fraction:
                await pilot.pause(0.02)
                active = app.session.runs.active
        times = await _latency(pilot, app.session, repeats)
        if running:
            begin = time.perf_counter()
            app.session.runs.stop()
            while any(worker.group == "transient" for worker in app.workers if worker.is_running):
                await asyncio.sleep(0.001)
            stops.append(time.perf_counter() - begin)
    found = [
        Measured(f"key answered {'while a run goes on' if running else 'at rest'}", times, 0.05)
    ]
    return found + ([Measured("stop, until the thread has ended", stops, 0.1)] if stops else [])


async def _measured(repeats: int) -> list[Measured]:
    return [
        await redraw(repeats),
        *await keys(repeats, running=False),
        *await keys(repeats, running=True),
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure how fast the terminal UI answers.")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--repeats", type=int, default=20)
    given = parser.parse_args()
    # The interpreted kernel, with which every session begins, shares one lock with the screen.
    with mock.patch.object(compiled, "kernels", KernelLoader("none")):
        found = [*first_frame(max(given.repeats // 4, 1)), *asyncio.run(_measured(given.repeats))]
    if given.json:
        print(json.dumps([measured.as_dict() for measured in found], indent=2))
        return
    for measured in found:
        row = measured.as_dict()
        times = f"{1e3 * row['median_s']:7.1f} ms ({1e3 * row['worst_s']:.1f})"
        print(f"{row['what']:45} {times:22} limit {1e3 * row['limit_s']:g} ms")


if __name__ == "__main__":
    main()

"""How long the terminal UI takes to its first frame, and to draw a million samples.

Run as ``python -m tests.benchmarks.plots``. Times are CPU time of this process.
"""

import asyncio
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

from fivtui.tui.chart import Chart, Guide, Trace, View
from fivtui.tui.picture import draw

SAMPLES = 1_000_000
SIZE = (100, 30)
_REPEATS = 5

_FIRST_FRAME = """
import asyncio, time
begin = time.perf_counter()
from fivtui.tui.app import FivtuiApp
async def main():
    async with FivtuiApp().run_test(size=(100, 30)) as pilot:
        await pilot.pause()
        print(time.perf_counter() - begin, time.process_time())
asyncio.run(main())
"""


def least(work: Callable[[], object]) -> float:
    """The least CPU time of some repeats, s."""
    times = []
    for _ in range(_REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


def charts() -> dict[str, Chart]:
    """What is drawn."""
    t = np.linspace(0.0, 1e4, SAMPLES)
    y = np.sin(5.0 * t) * (1.0 + 0.5 * np.sin(0.013 * t))
    over = Chart(
        "t / s", "y / m", (Trace("", t, y),), guides=(Guide(0.0, vertical=False),), strip=[(1, 9)]
    )
    plane = Chart("y", "vy", (Trace("", y, np.roll(y, 200), ordered=False),), tight=False)
    return {"over time": over, "phase portrait": plane}


async def painted(chart: Chart) -> float:
    """The CPU time of drawing and painting in an app, s."""
    from textual.app import App, ComposeResult

    from fivtui.tui.chart_view import ChartView

    class Plain(App[None]):
        def compose(self) -> ComposeResult:
            yield ChartView("chart")

    times = []
    async with Plain().run_test(size=SIZE) as pilot:
        view = pilot.app.query_one(ChartView)
        for _ in range(_REPEATS):
            begin = time.process_time()
            view.show(chart)
            await pilot.pause()
            times.append(time.process_time() - begin)
    return min(times)


def main() -> None:
    """Print all times."""
    for name, chart in charts().items():

        def work(chart: Chart = chart) -> object:
            return draw(chart, View(), *SIZE)

        whole = asyncio.run(painted(chart))
        print(
            f"{name}, {SAMPLES} samples: {1e3 * least(work):.1f} ms, painted {1e3 * whole:.1f} ms"
        )
    done = subprocess.run(
        [sys.executable, "-c", _FIRST_FRAME], check=True, capture_output=True, text=True
    )
    wall, cpu = map(float, done.stdout.split())
    print(f"first frame: {wall:.2f} s, CPU time of all {cpu:.2f} s")


if __name__ == "__main__":
    main()

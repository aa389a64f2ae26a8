"""The end of the program waits for files being written, but not for computations."""

import asyncio
import threading

import pytest
from textual.worker import Worker

from fivtui.tui.app import FivtuiApp
from fivtui.tui.session.jobs import ComputingThreads, FileWrites
from tests.support.laboratory import until


def test_the_end_does_not_wait_for_a_thread() -> None:
    released, threads = threading.Event(), ComputingThreads()

    def fail() -> None:
        raise ZeroDivisionError("by zero")

    async def main() -> int:
        loop = asyncio.get_running_loop()
        loop.set_default_executor(threads)
        loop.run_in_executor(None, released.wait)
        with pytest.raises(ZeroDivisionError):
            await loop.run_in_executor(None, fail)
        return await loop.run_in_executor(None, int, "3")

    # The threads of asyncio's own executor would block here.
    assert asyncio.run(main()) == 3
    assert threads.busy
    released.set()


def test_the_end_waits_for_files_being_written() -> None:
    writing, inside, go_on = FileWrites(), threading.Event(), threading.Event()
    written: list[str] = []

    def write() -> None:
        with writing.track("slider.gif"):
            inside.set()
            go_on.wait()
            written.append("whole")

    writing.wait(written.append)
    thread = threading.Thread(target=write)
    thread.start()
    inside.wait()

    def end() -> None:
        writing.wait(record)
        written.append("end")

    def record(names: str) -> None:
        # The writer continues only after this message.
        written.append(names)
        go_on.set()

    waiting = threading.Thread(target=end)
    waiting.start()
    waiting.join()
    thread.join()
    assert written == ["slider.gif", "whole", "end"]


async def test_the_laboratory_computes_in_threads_that_do_not_hold_its_end() -> None:
    released, threads = threading.Event(), ComputingThreads()
    app = FivtuiApp(threads=threads)
    async with app.run_test(size=(80, 24)) as pilot:
        worker: Worker[bool] = app.run_worker(released.wait, thread=True)
        await until(pilot, lambda: threads.busy)
        assert worker.is_running
        await pilot.press("ctrl+q")
    assert app._exit
    assert threads.busy
    released.set()

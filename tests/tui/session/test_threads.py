"""The end of the program waits for files being written, but not for computations."""

import asyncio
import threading

import pytest
from textual.worker import Worker

from fivtui.tui.app import FivtuiApp
from fivtui.tui.session.jobs import ComputingThreads, FileWrites
from tests.support.laboratory import until


def test_the_program_ends_without_waiting_for_a_thread() -> None:
    thread_may_end, threads = threading.Event(), ComputingThreads()

    def fail() -> None:
        raise ZeroDivisionError("by zero")

    async def compute_in_threads() -> int:
        loop = asyncio.get_running_loop()
        loop.set_default_executor(threads)
        loop.run_in_executor(None, thread_may_end.wait)
        with pytest.raises(ZeroDivisionError):
            await loop.run_in_executor(None, fail)
        return await loop.run_in_executor(None, int, "3")

    # The threads of asyncio's own executor would block here.
    assert asyncio.run(compute_in_threads()) == 3
    assert threads.busy
    thread_may_end.set()


def test_the_program_ends_after_files_are_written() -> None:
    file_writes, write_started, write_may_end = FileWrites(), threading.Event(), threading.Event()
    events: list[str] = []

    def write() -> None:
        with file_writes.track("slider.gif"):
            write_started.set()
            write_may_end.wait()
            events.append("whole")

    # Before a file is written, this neither waits nor reports names.
    file_writes.wait(events.append)
    writing_thread = threading.Thread(target=write)
    writing_thread.start()
    write_started.wait()

    def wait_for_files() -> None:
        file_writes.wait(record_names)
        events.append("end")

    def record_names(names: str) -> None:
        # The writer continues only after this message.
        events.append(names)
        write_may_end.set()

    waiting_thread = threading.Thread(target=wait_for_files)
    waiting_thread.start()
    waiting_thread.join()
    writing_thread.join()
    assert events == ["slider.gif", "whole", "end"]


async def test_the_laboratory_ends_without_waiting_for_computing_threads() -> None:
    thread_may_end, threads = threading.Event(), ComputingThreads()
    app = FivtuiApp(threads=threads)
    async with app.run_test(size=(80, 24)) as pilot:
        worker: Worker[bool] = app.run_worker(thread_may_end.wait, thread=True)
        await until(pilot, lambda: threads.busy)
        assert worker.is_running
        await pilot.press("ctrl+q")
    assert app._exit
    assert threads.busy
    thread_may_end.set()

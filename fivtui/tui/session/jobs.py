"""Computations in threads, with progress and stop. Imports no Textual."""

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Final, Generic, ParamSpec, TypeVar

from fivtui.io import system_limit_error
from fivtui.model import Cancelled, ComputationError, InputError

P = ParamSpec("P")
T = TypeVar("T")

# Maximum time for which a computing thread waits for the response to a key, s.
_RESPONSE_TIME_S: Final = 0.06
_POLL_INTERVAL_S: Final = 0.005
# Time after which the names of unfinished files are displayed at the exit, s.
_REPORT_DELAY_S: Final = 0.2
_THREAD_NAME: Final = "computing"


class ScreenResponse:
    """The response of the screen to a key: computing threads pause for it, at most for a moment.

    Without the pause, computing Python threads would double its response time.
    """

    # End of the pause by the monotonic clock, s.
    _pause_end = 0.0

    def begin(self) -> None:
        """Pause computing threads after a key press."""
        self._pause_end = time.monotonic() + _RESPONSE_TIME_S

    def end(self) -> None:
        """End the pause, because the response to the key is displayed."""
        self._pause_end = 0.0

    @property
    def pending(self) -> bool:
        """Whether the screen is responding to a key, so that computing threads pause."""
        return time.monotonic() < self._pause_end

    def wait(self) -> None:
        """Wait until the screen has responded; computing threads call it between units of work.

        Further keys do not extend the wait.
        """
        deadline = time.monotonic() + _RESPONSE_TIME_S
        while time.monotonic() < min(self._pause_end, deadline):
            time.sleep(_POLL_INTERVAL_S)


SCREEN_RESPONSE: Final = ScreenResponse()


class FileWrites:
    """Registers the files that threads are writing, so that the program waits for them."""

    def __init__(self) -> None:
        self._names: list[str] = []
        self._changed = threading.Condition()

    @contextmanager
    def track(self, name: str) -> Iterator[None]:
        """Register a file while it is being written."""
        with self._changed:
            self._names.append(name)
        try:
            yield
        finally:
            with self._changed:
                self._names.remove(name)
                self._changed.notify_all()

    def wait(self, show: Callable[[str], object]) -> None:
        """Wait until all files are written; after a moment, `show` their names."""
        with self._changed:
            if not self._changed.wait_for(lambda: not self._names, _REPORT_DELAY_S):
                show(", ".join(self._names))
                self._changed.wait_for(lambda: not self._names)


FILE_WRITES: Final = FileWrites()


class ComputingThreads(ThreadPoolExecutor):
    """Runs every function in a new thread; the program does not wait for threads at its exit.

    asyncio accepts only a `ThreadPoolExecutor`; its pool is not used.
    """

    def __init__(self) -> None:
        super().__init__(max_workers=1)
        self._is_shut_down = False

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Start a function in a thread."""
        future: Future[T] = Future()

        def run() -> None:
            if not future.set_running_or_notify_cancel():
                # The future was cancelled before the thread began.
                return
            try:
                settle = partial(future.set_result, fn(*args, **kwargs))
            except BaseException as error:  # noqa: BLE001 (the future raises it)
                settle = partial(future.set_exception, error)
            if not self._is_shut_down:
                settle()

        threading.Thread(target=run, name=_THREAD_NAME, daemon=True).start()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: ARG002
        """Ignore the results of threads that are still running."""
        self._is_shut_down = True

    @property
    def busy(self) -> bool:
        """Whether a thread is running."""
        return any(thread.name == _THREAD_NAME for thread in threading.enumerate())


def duration_text(seconds: float) -> str:
    """A duration in hours, minutes and seconds."""
    minutes, whole_seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {whole_seconds:02d} s" if minutes else f"{seconds:.1f} s"


@dataclass(eq=False, slots=True, kw_only=True)
class Job:
    """A computation in a thread; its completed fraction (0 to 1) is written by that thread."""

    fraction: float = 0.0
    # What is known of the result so far, in words.
    note: str = ""
    # Whether the job was asked to stop.
    stopped: bool = False
    _start_time: float = field(default_factory=time.monotonic)

    def report(self, fraction: float) -> bool:
        """Record progress. Returns False to stop. Called by the computing thread."""
        self.fraction = max(self.fraction, fraction)
        SCREEN_RESPONSE.wait()
        return not self.stopped

    def stop(self) -> None:
        """Ask the computing thread to stop."""
        self.stopped = True

    @property
    def elapsed(self) -> float:
        """Time since the start, s."""
        return time.monotonic() - self._start_time

    @property
    def progress_text(self) -> str:
        """Progress and remaining time, such as ``40 %, 2.5 s left``."""
        fraction, text = self.fraction, _percent(self.fraction)
        if fraction > 0.0:
            text += f", {duration_text(self.elapsed * (1.0 - fraction) / fraction)} left"
        return text

    @property
    def stop_text(self) -> str:
        """The text that reports a stopped job and its progress."""
        return f"stopped at {_percent(self.fraction)}"


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.0f} %"


@dataclass(frozen=True, slots=True)
class Outcome(Generic[T]):
    """How a computation ended: a result, an error, or neither if stopped."""

    result: T | None = None
    error: str = ""


def compute_outcome(compute: Callable[[], T]) -> Outcome[T]:
    """Call a function; the outcome is its result, or its error if that is an expected one."""
    try:
        return Outcome(compute())
    except Cancelled:
        return Outcome()
    except (InputError, ComputationError) as error:
        return Outcome(error=str(error))


def crash_message(error: BaseException | None) -> str:
    """Message for an unexpected error in a thread."""
    limit_message = system_limit_error(error) if isinstance(error, OSError) else None
    return str(limit_message) if limit_message else f"unexpected {type(error).__name__}: {error}"

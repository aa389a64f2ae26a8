"""Computations in threads, whose outcomes return to the screen's thread."""

from collections.abc import Callable
from typing import TypeVar

from textual.widget import Widget

from fivtui.tui.session import Outcome, crash_message

T = TypeVar("T")


def compute_in_thread(
    owner: Widget,
    compute: Callable[[], Outcome[T]],
    receive: Callable[[Outcome[T]], object],
) -> None:
    """Call `compute` in a thread, then `receive` with its outcome in the thread of the owner.

    An unexpected error becomes an outcome, too.
    """

    def run() -> None:
        try:
            outcome = compute()
        except Exception as error:  # noqa: BLE001 (it is displayed)
            outcome = Outcome(error=crash_message(error))
        owner.call_later(receive, outcome)

    owner.run_worker(run, thread=True, exit_on_error=False)

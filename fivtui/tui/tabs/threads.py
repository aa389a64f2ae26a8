"""Computations in threads, whose outcomes return to the screen's thread."""

from collections.abc import Callable
from typing import TypeVar

from textual.widget import Widget

from fivtui.tui.session import Outcome, crash_message

T = TypeVar("T")


def compute_in_thread(
    owner: Widget, compute: Callable[[], Outcome[T]], show_outcome: Callable[[Outcome[T]], object]
) -> None:
    """Call `compute` in a thread, then `show_outcome` with its outcome in the thread of `owner`.

    The outcome of an unexpected error is its message.
    """

    def compute_and_report() -> None:
        try:
            outcome = compute()
        except Exception as error:  # noqa: BLE001 (it is displayed)
            outcome = Outcome(error=crash_message(error))
        owner.call_later(show_outcome, outcome)

    owner.run_worker(compute_and_report, thread=True, exit_on_error=False)

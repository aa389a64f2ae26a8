"""A line to type in."""

from typing import Any

from textual.timer import Timer
from textual.widgets import Input


class TextInput(Input):
    """An input that leaves no timer behind.

    Textual stops the timers of a widget when that is closed, then lets it deal with the messages
    that wait. If it was closed while it was opening, one of them begins the blinking of the cursor.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._intervals: list[Timer] = []
        super().__init__(*args, **kwargs)

    def set_interval(self, *args: Any, **kwargs: Any) -> Timer:
        """Begin a timer, and note it."""
        self._intervals.append(super().set_interval(*args, **kwargs))
        return self._intervals[-1]

    def on_unmount(self) -> None:
        """Stop all timers, also those begun late."""
        for timer in self._intervals:
            timer.stop()

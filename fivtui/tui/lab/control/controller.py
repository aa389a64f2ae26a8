"""The base class of what computes in the background for the main screen."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, Generic, TypeVar

from textual.timer import Timer

from fivtui.tui.session import Job

if TYPE_CHECKING:
    from fivtui.tui.lab.screen import LabScreen

# Pause after the last edit, s.
_PAUSE: Final = 0.4

AnyJob = TypeVar("AnyJob", bound=Job)


class Controller(Generic[AnyJob]):
    """Computes in threads for the screen, one job at a time, at once or after a pause."""

    def __init__(self, screen: "LabScreen") -> None:
        self._screen = screen
        self._session = screen.session
        # The running job, and the pause before the next one.
        self._job: AnyJob | None = None
        self._pause_timer: Timer | None = None

    def stop(self) -> None:
        """Stop the job, whose results are then ignored, or the pause."""
        if self._pause_timer is not None:
            self._pause_timer.stop()
        if self._job is not None:
            self._job.stop()
        self._pause_timer = self._job = None

    def start_after_pause(self, start: Callable[[], None]) -> None:
        """Call `start` after a pause, or after the first pause in which the screen is idle."""
        self._pause_timer = self._screen.set_timer(_PAUSE, partial(self._end_pause, start))

    def _end_pause(self, start: Callable[[], None]) -> None:
        if self._screen.is_busy:
            self.start_after_pause(start)
        else:
            start()

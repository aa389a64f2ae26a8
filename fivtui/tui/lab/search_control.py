"""Background search for attractors that coexist with a stable equilibrium."""

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from textual.screen import Screen
from textual.timer import Timer

from fivtui.model import Parameters
from fivtui.tui.session import Coexisting, Job, outcome_of
from fivtui.tui.tabs import SearchUpdated

if TYPE_CHECKING:
    from fivtui.orbits import Coexistence

# Delay of a search after the last edit, s.
_PAUSE: Final = 0.5
# Number of parameter sets whose results are cached.
_REMEMBERED: Final = 64
_GROUP: Final = "search"

Key = tuple[Parameters, bool]


class SearchController:
    """Searches for attractors of the edited parameter set, one search at a time, for a screen.

    An edit stops the search; late results are dropped.
    """

    def __init__(self, screen: Screen[None]) -> None:
        self._screen = screen
        self._key: Key | None = None
        self._job: Job | None = None
        self._waiting: Timer | None = None
        self._known: OrderedDict[Key, Coexisting] = OrderedDict()

    def coexisting(self, p: Parameters, *, separation: bool, stable: bool) -> Coexisting | None:
        """Known attractors beside a stable equilibrium; starts a search if there are none yet.

        Returns None if the equilibrium is not stable.
        """
        key = (p, separation) if stable else None
        if key != self._key:
            self.stop()
            self._key = key
            if key is not None and (key not in self._known or not self._known[key].done):
                self._waiting = self._screen.set_timer(_PAUSE, self._begin)
        return None if key is None else self._known.get(key, Coexisting())

    def stop(self) -> None:
        """Stop the search."""
        self._key = None
        if self._waiting is not None:
            self._waiting.stop()
            self._waiting = None
        if self._job is not None:
            self._job.stop()
            self._job = None

    def _begin(self) -> None:
        if self._key is None:
            return
        (p, separation), self._waiting = self._key, None
        self._job = job = Job()

        def tell(found: "Coexistence", *, done: bool = False) -> None:
            self._screen.post_message(SearchUpdated(job, found, done=done))

        def search() -> None:
            from fivtui.orbits import coexistence

            ended = outcome_of(
                lambda: coexistence(p, separation=separation, progress=job.report, found=tell)
            )
            if ended.error:
                self._screen.post_message(SearchUpdated(job, error=ended.error))
            elif ended.result is not None:
                tell(ended.result, done=True)

        self._screen.run_worker(
            search, name="search for limit cycles", group=_GROUP, thread=True, exit_on_error=False
        )

    def take(self, event: SearchUpdated) -> bool:
        """Store a search's result. Returns False if it is not of the edited parameter set."""
        if event.job is not self._job or self._key is None:
            return False
        if event.found is None:
            coexisting = Coexisting(f"search for limit cycles failed: {event.error}", done=True)
        else:
            from fivtui.orbits import coexistence_words, warning_of

            note = warning_of(event.found) if event.done else None
            coexisting = Coexisting(
                coexistence_words(event.found), note or "", event.found.coexists, event.done
            )
        self._known[self._key] = coexisting
        while len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)
        if event.done:
            self._job = None
        return True

"""The search for what coexists with a stable equilibrium, in the background."""

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

from textual.screen import Screen
from textual.timer import Timer

from fivtui.model.errors import Cancelled, ComputationError
from fivtui.model.parameters import Parameters
from fivtui.tui.session.jobs import Job
from fivtui.tui.session.report import Beside
from fivtui.tui.tabs.messages import Searched

if TYPE_CHECKING:
    from fivtui.orbits.attractor_search import Coexistence

# A search begins when nothing was edited for so long, s.
_PAUSE: Final = 0.5
# Parameter sets whose searches are remembered.
_REMEMBERED: Final = 64
_GROUP: Final = "search"

Key = tuple[Parameters, bool]


class SearchDesk:
    """Searches for attractors beside the equilibrium of what is edited, for a screen.

    One search at a time: an edit stops it, and what it may still find is dropped.

    Parameters
    ----------
    screen : Screen
        Owns the thread and gets the messages.
    """

    def __init__(self, screen: Screen[None]) -> None:
        self._screen = screen
        self._key: Key | None = None
        self._job: Job | None = None
        self._waiting: Timer | None = None
        self._known: OrderedDict[Key, Beside] = OrderedDict()

    def beside(self, p: Parameters, *, separation: bool, stable: bool) -> Beside | None:
        """What is known beside an equilibrium by now; its search begins soon if there was none.

        Parameters
        ----------
        p : Parameters
            What is edited.
        separation : bool
            Whether separation is considered.
        stable : bool
            Whether its equilibrium is stable: nothing is searched beside another one.

        Returns
        -------
        Beside or None
            None if the equilibrium is not stable.
        """
        key = (p, separation) if stable else None
        if key != self._key:
            self.stop()
            self._key = key
            if key is not None and (key not in self._known or not self._known[key].done):
                self._waiting = self._screen.set_timer(_PAUSE, self._begin)
        return None if key is None else self._known.get(key, Beside())

    def stop(self) -> None:
        """Stop what is under way or about to begin."""
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
            self._screen.post_message(Searched(job, found, done=done))

        def search() -> None:
            from fivtui.orbits.attractor_search import coexistence

            try:
                found = coexistence(p, separation=separation, progress=job.report, found=tell)
            except Cancelled:
                return
            except ComputationError as error:
                self._screen.post_message(Searched(job, error=str(error)))
                return
            tell(found, done=True)

        self._screen.run_worker(
            search, name="search for limit cycles", group=_GROUP, thread=True, exit_on_error=False
        )

    def take(self, event: Searched) -> bool:
        """Take in what a search found; whether it is of what is edited now.

        Parameters
        ----------
        event : Searched
            The search and its result.
        """
        if event.job is not self._job or self._key is None:
            return False
        if event.found is None:
            beside = Beside(f"limit cycles not searched: {event.error}", done=True)
        else:
            from fivtui.orbits.files import warning_of
            from fivtui.orbits.words import coexistence_words

            note = warning_of(event.found) if event.done else None
            beside = Beside(
                coexistence_words(event.found), note or "", event.found.coexists, event.done
            )
        self._known[self._key] = beside
        while len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)
        if event.done:
            self._job = None
        return True

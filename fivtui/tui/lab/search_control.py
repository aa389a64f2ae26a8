"""Background search for what waits beyond small disturbances of the edited scene."""

from collections import OrderedDict
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from textual.screen import Screen
from textual.timer import Timer

from fivtui.model import System
from fivtui.tui.session import Coexisting, Job, outcome_of
from fivtui.tui.tabs import SearchUpdated

if TYPE_CHECKING:
    from fivtui.orbits import Coexistence
    from fivtui.safety import SafeFriction

# Delay of a search after the last edit, s.
_PAUSE: Final = 0.5
# Number of parameter sets whose results are cached.
_REMEMBERED: Final = 64
_GROUP: Final = "search"

Key = tuple[System, bool]


class SearchController:
    """Searches for attractors of the edited parameter set, one search at a time, for a screen.

    First those that coexist with a stable equilibrium, then the friction below which there are
    none; on a belt of finite speed the first alone. An edit stops the search; late results are
    dropped.
    """

    def __init__(self, screen: Screen[None]) -> None:
        self._screen = screen
        self._key: Key | None = None
        self._job: Job | None = None
        self._waiting: Timer | None = None
        self._known: OrderedDict[Key, Coexisting] = OrderedDict()
        self._found: Coexistence | None = None

    def coexisting(self, system: System, *, stable: bool) -> Coexisting:
        """What is known beside the equilibrium; starts a search if it is not all known yet."""
        key = (system, stable)
        if key != self._key:
            self.stop()
            self._key = key
            if key not in self._known or not self._known[key].searched:
                self._waiting = self._screen.set_timer(_PAUSE, self._begin)
        return self._known.get(key, Coexisting() if stable else Coexisting(words=""))

    def stop(self) -> None:
        """Stop the search."""
        self._key = self._found = None
        if self._waiting is not None:
            self._waiting.stop()
            self._waiting = None
        if self._job is not None:
            self._job.stop()
            self._job = None

    def _begin(self) -> None:
        if self._key is None:
            return
        (system, stable), self._waiting = self._key, None
        self._job = job = Job()

        def tell(found: "Coexistence", *, done: bool = False) -> None:
            self._screen.post_message(SearchUpdated(job, found, done=done))

        def search() -> None:
            from fivtui.orbits import coexistence
            from fivtui.safety import safe_friction

            if stable:
                ended = outcome_of(lambda: coexistence(system, progress=job.report, found=tell))
                if ended.error:
                    self._screen.post_message(SearchUpdated(job, error=ended.error))
                elif ended.result is not None:
                    tell(ended.result, done=True)
                else:
                    return
            p = system.parameters
            if p.v_belt is not None:
                self._screen.post_message(SearchUpdated(job, last=True))
                return
            safe = outcome_of(
                lambda: safe_friction(p, separation=system.separation, progress=job.report)
            )
            if safe.result is not None or safe.error:
                self._screen.post_message(SearchUpdated(job, safe=safe.result, last=True))

        self._screen.run_worker(
            search, name="search for limit cycles", group=_GROUP, thread=True, exit_on_error=False
        )

    def take(self, event: SearchUpdated) -> bool:
        """Store a search's result. Returns False if it is not of the edited parameter set."""
        if event.job is not self._job or self._key is None:
            return False
        before = self._known.get(self._key, Coexisting(words=""))
        self._known[self._key] = (
            self._completed(before, event.safe) if event.last else self._coexisting(event)
        )
        while len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)
        if event.last:
            self._job = None
        return True

    def _coexisting(self, event: SearchUpdated) -> Coexisting:
        if event.found is None:
            return Coexisting(f"search for limit cycles failed: {event.error}", done=True)
        from fivtui.orbits import coexistence_words

        self._found = event.found
        note = event.found.warning if event.done else None
        return Coexisting(
            coexistence_words(event.found), note or "", event.found.coexists, event.done
        )

    def _completed(self, before: Coexisting, safe: "SafeFriction | None") -> Coexisting:
        known = replace(before, safe=safe, searched=True)
        if safe is None or not before.words:
            return known
        from fivtui.orbits import coexistence_words
        from fivtui.safety import coexistence_here

        if self._found is not None and self._found.coexists and safe.others:
            since = f" from μ = {safe.others[0].mu:.4g}"
            return replace(known, words=coexistence_words(self._found, since))
        here = coexistence_here(safe)
        return replace(known, words=here, coexists=True) if here else known

"""Searches in a thread for vibrations of the edited scene that a large disturbance starts.

The first search finds attractors, such as limit cycles, that coexist with a stable equilibrium. The
second finds the safe μ: the friction below which no disturbance leads to vibration. With separation
the slider may leave the belt.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from textual.timer import Timer

from fivtui.model import System
from fivtui.tui.session import Attractors, Job, compute_outcome

if TYPE_CHECKING:
    from fivtui.orbits import Coexistence
    from fivtui.safety import SafeFriction

    from .screen import LabScreen

# Delay of a search after the last edit, s.
_PAUSE: Final = 0.5
# Number of parameter sets whose results are cached.
_CACHE_SIZE: Final = 64

# A parameter set, and whether its equilibrium is stable.
CacheKey = tuple[System, bool]


class SearchController:
    """Searches for attractors of the edited parameter set, one search at a time.

    An edit stops the search, and its results are ignored. A search with a finite belt speed finds
    no safe μ.
    """

    def __init__(self, screen: "LabScreen") -> None:
        self._screen = screen
        self._key: CacheKey | None = None
        self._job: Job | None = None
        self._pause_timer: Timer | None = None
        self._cache: OrderedDict[CacheKey, Attractors] = OrderedDict()
        self._coexistence: Coexistence | None = None

    def attractors(self, system: System, *, stable: bool) -> Attractors:
        """The results so far; schedules a search if the parameters are new.

        `stable` is whether the equilibrium is stable.
        """
        key = (system, stable)
        if key != self._key:
            self.stop()
            self._key = key
            if key not in self._cache or not self._cache[key].complete:
                self._pause_timer = self._screen.set_timer(_PAUSE, self._start_after_pause)
        # Without results, the text says that the search is running; there is no such search for
        # an unstable equilibrium.
        return self._cache.get(key, Attractors() if stable else Attractors(text=""))

    def stop(self) -> None:
        """Stop the search."""
        self._key = self._coexistence = None
        if self._pause_timer is not None:
            self._pause_timer.stop()
            self._pause_timer = None
        if self._job is not None:
            self._job.stop()
            self._job = None

    def _start_after_pause(self) -> None:
        if self._screen.is_busy:
            self._pause_timer = self._screen.set_timer(_PAUSE, self._start_after_pause)
        else:
            self._start_search()

    def _start_search(self) -> None:
        if self._key is None:
            return
        (system, stable), self._pause_timer = self._key, None
        self._job = job = Job()

        def post(store: Callable[..., None], *args: object) -> None:
            self._screen.call_later(self._store_and_show, job, store, *args)

        def store_partial_coexistence(result: "Coexistence") -> None:
            post(self._store_coexistence, result, False)

        def search() -> None:
            from fivtui.orbits import coexistence
            from fivtui.safety import safe_friction

            if stable:
                outcome = compute_outcome(
                    lambda: coexistence(
                        system, progress=job.report, on_found=store_partial_coexistence
                    )
                )
                if outcome.error:
                    post(self._store_error, outcome.error)
                elif outcome.result is not None:
                    post(self._store_coexistence, outcome.result, True)
                else:
                    # The search was stopped.
                    return
            parameters = system.parameters
            if parameters.v_belt is not None:
                post(self._store_safe_friction, None)
                return
            safe = compute_outcome(
                lambda: safe_friction(parameters, separation=system.separation, progress=job.report)
            )
            if safe.result is not None or safe.error:
                post(self._store_safe_friction, safe.result)

        self._screen.run_in_thread("search for limit cycles", search)

    def _store_and_show(self, job: Job, store: Callable[..., None], *args: object) -> None:
        # Call `store(key, *args)` in the screen's thread, unless the parameters were edited since.
        if job is not self._job or self._key is None:
            return
        store(self._key, *args)
        while len(self._cache) > _CACHE_SIZE:
            self._cache.popitem(last=False)
        self._screen.show_search_result()

    def _store_error(self, key: CacheKey, error: str) -> None:
        self._cache[key] = Attractors(f"search for limit cycles failed: {error}", searched=True)

    def _store_coexistence(self, key: CacheKey, result: "Coexistence", searched: bool) -> None:
        # `searched`: whether this search has ended; that for the safe μ, which sets `complete`,
        # follows.
        from fivtui.orbits import coexistence_phrase

        self._coexistence = result
        note = (result.warning or "") if searched else ""
        self._cache[key] = Attractors(coexistence_phrase(result), note, result.coexists, searched)

    def _store_safe_friction(self, key: CacheKey, safe: "SafeFriction | None") -> None:
        # The last result of a search. It may know from which μ on limit cycles exist, or know one
        # that the first search has not found: the text on coexistence is changed to say so.
        self._job = None
        previous = self._cache.get(key, Attractors(text=""))
        self._cache[key] = replace(previous, safe=safe, complete=True)
        if safe is None or not previous.text:
            return
        from fivtui.orbits import coexistence_phrase
        from fivtui.safety import largest_cycle_text

        coexistence = self._coexistence
        attractors_below_critical_mu = safe.others
        if coexistence is not None and coexistence.coexists and attractors_below_critical_mu:
            suffix = f" from μ = {attractors_below_critical_mu[0].mu:.4g}"
            self._cache[key] = replace(
                self._cache[key], text=coexistence_phrase(coexistence, suffix)
            )
        elif sentence := largest_cycle_text(safe):
            self._cache[key] = replace(self._cache[key], text=sentence, coexists=True)

"""Searches in a thread for vibrations of the edited scene that a large disturbance starts.

The first search finds attractors, such as limit cycles, that coexist with a stable equilibrium. The
second finds the safe μ: the friction below which no disturbance leads to vibration. With separation
the slider may leave the belt.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from textual.cache import LRUCache

from fivtui.model import System
from fivtui.tui.session import Attractors, Job, compute_outcome

from .controller import Controller

if TYPE_CHECKING:
    from fivtui.orbits import Coexistence
    from fivtui.tui.lab.screen import LabScreen

# Number of parameter sets whose results are cached.
_CACHE_SIZE: Final = 64

# A parameter set, and whether its equilibrium is stable.
CacheKey = tuple[System, bool]


class SearchController(Controller[Job]):
    """Searches for attractors of the edited parameter set; an edit stops the search.

    A search with a finite belt speed finds no safe μ.
    """

    def __init__(self, screen: "LabScreen") -> None:
        super().__init__(screen)
        self._key: CacheKey | None = None
        self._cache: LRUCache[CacheKey, Attractors] = LRUCache(_CACHE_SIZE)

    def attractors(self, system: System, *, stable: bool) -> Attractors:
        """The results so far; schedules a search if the parameters are new.

        `stable` is whether the equilibrium is stable.
        """
        key = (system, stable)
        # Without results, the text says that the search is running; there is no such search for
        # an unstable equilibrium.
        attractors = self._cache.get(key, Attractors() if stable else Attractors(text=""))
        if key != self._key:
            self.stop()
            self._key = key
            if not attractors.complete:
                self.start_after_pause(partial(self._start, key))
        return attractors

    def stop(self) -> None:
        """Stop the search."""
        super().stop()
        self._key = None

    def _start(self, key: CacheKey) -> None:
        self._job = job = Job()
        post = partial(self._screen.call_later, self._store, job, key)
        self._screen.run_in_thread("search for limit cycles", lambda: _search(*key, job, post))

    def _store(self, job: Job, key: CacheKey, attractors: Attractors) -> None:
        if job is self._job:
            # An LRUCache keeps the first value of a key.
            self._cache.discard(key)
            self._cache[key] = attractors
            self._screen.show_search_result()


def _search(system: System, stable: bool, job: Job, post: Callable[[Attractors], object]) -> None:
    # Both searches; `stable` is whether the equilibrium is stable. Returns early when stopped.
    from fivtui.orbits import coexistence, coexistence_phrase
    from fivtui.safety import largest_cycle_text, safe_friction

    def post_partial_result(result: "Coexistence") -> None:
        post(Attractors(coexistence_phrase(result), coexists=result.coexists))

    attractors, coexisting, safe = Attractors(text=""), None, None
    if stable:
        outcome = compute_outcome(
            lambda: coexistence(system, progress=job.report, on_found=post_partial_result)
        )
        coexisting = outcome.result
        if coexisting is not None:
            text, note = coexistence_phrase(coexisting), coexisting.warning or ""
            attractors = Attractors(text, note, coexisting.coexists, searched=True)
        elif outcome.error:
            text = f"search for limit cycles failed: {outcome.error}"
            attractors = Attractors(text, searched=True)
        else:
            return
        post(attractors)
    parameters = system.parameters
    if parameters.v_belt is None:
        safe_outcome = compute_outcome(
            lambda: safe_friction(parameters, separation=system.separation, progress=job.report)
        )
        safe = safe_outcome.result
        if safe is None and not safe_outcome.error:
            return
    if stable and safe is not None:
        # From which μ on limit cycles exist, or that the second search has found one.
        if coexisting is not None and coexisting.coexists and safe.others:
            text = coexistence_phrase(coexisting, f" from μ = {safe.others[0].mu:.4g}")
            attractors = replace(attractors, text=text)
        elif text := largest_cycle_text(safe):
            attractors = replace(attractors, text=text, coexists=True)
    post(replace(attractors, safe=safe, complete=True))

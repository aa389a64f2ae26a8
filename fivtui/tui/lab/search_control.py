"""Searches in a thread for vibrations of the edited scene that a large disturbance starts.

The first search finds attractors, such as limit cycles, that coexist with a stable equilibrium. The
second finds the safe μ: the friction below which no disturbance leads to vibration. With separation
the slider may leave the belt.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from functools import partial
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

    def attractors(self, system: System, *, stable: bool) -> Attractors:
        """The results so far; schedules a search if the parameters are new.

        `stable` is whether the equilibrium is stable.
        """
        key = (system, stable)
        if key != self._key:
            self.stop()
            self._key = key
            if key not in self._cache or not self._cache[key].complete:
                self._pause_timer = self._screen.set_timer(_PAUSE, self._start)
        # Without results, the text says that the search is running; there is no such search for
        # an unstable equilibrium.
        return self._cache.get(key, Attractors() if stable else Attractors(text=""))

    def stop(self) -> None:
        """Stop the search."""
        self._key = None
        if self._pause_timer is not None:
            self._pause_timer.stop()
            self._pause_timer = None
        if self._job is not None:
            self._job.stop()
            self._job = None

    def _start(self) -> None:
        if self._screen.is_busy:
            self._pause_timer = self._screen.set_timer(_PAUSE, self._start)
        elif self._key is not None:
            self._pause_timer = None
            self._job = job = Job()
            show_attractors = partial(self._screen.call_later, self._store, job)
            search = partial(_search, *self._key, job, show_attractors)
            self._screen.run_in_thread("search for limit cycles", search)

    def _store(self, job: Job, attractors: Attractors) -> None:
        # Results of a stopped search are ignored.
        if job is not self._job or self._key is None:
            return
        self._cache[self._key] = attractors
        while len(self._cache) > _CACHE_SIZE:
            self._cache.popitem(last=False)
        if attractors.complete:
            self._job = None
        self._screen.show_search_result()


def _search(
    system: System, stable: bool, job: Job, show_attractors: Callable[[Attractors], object]
) -> None:
    # Both searches; `stable` is whether the equilibrium is stable. Returns early when stopped.
    from fivtui.orbits import coexistence
    from fivtui.safety import safe_friction

    def show_partial_result(result: "Coexistence") -> None:
        show_attractors(_attractors(result, searched=False))

    attractors, coexisting = Attractors(text=""), None
    if stable:
        outcome = compute_outcome(
            lambda: coexistence(system, progress=job.report, on_found=show_partial_result)
        )
        coexisting = outcome.result
        if coexisting is not None:
            attractors = _attractors(coexisting, searched=True)
        elif outcome.error:
            text = f"search for limit cycles failed: {outcome.error}"
            attractors = Attractors(text, searched=True)
        else:
            return
        show_attractors(attractors)
    parameters, safe = system.parameters, None
    if parameters.v_belt is None:
        safe_outcome = compute_outcome(
            lambda: safe_friction(parameters, separation=system.separation, progress=job.report)
        )
        safe = safe_outcome.result
        if safe is None and not safe_outcome.error:
            return
    attractors = replace(attractors, safe=safe, complete=True)
    if safe is not None and attractors.text:
        attractors = _with_safe_friction(attractors, safe, coexisting)
    show_attractors(attractors)


def _attractors(result: "Coexistence", *, searched: bool) -> Attractors:
    # `searched`: whether the search for coexisting attractors has ended.
    from fivtui.orbits import coexistence_phrase

    note = (result.warning or "") if searched else ""
    return Attractors(coexistence_phrase(result), note, result.coexists, searched)


def _with_safe_friction(
    attractors: Attractors, safe: "SafeFriction", coexisting: "Coexistence | None"
) -> Attractors:
    # The text says from which μ on limit cycles exist, or that the second search has found one.
    from fivtui.orbits import coexistence_phrase
    from fivtui.safety import largest_cycle_text

    if coexisting is not None and coexisting.coexists and safe.others:
        text = coexistence_phrase(coexisting, f" from μ = {safe.others[0].mu:.4g}")
        return replace(attractors, text=text)
    text = largest_cycle_text(safe)
    return replace(attractors, text=text, coexists=True) if text else attractors

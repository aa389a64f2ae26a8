"""Background search for attractors of the edited scene beside the equilibrium."""

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

Key = tuple[System, bool]


class SearchController:
    """Searches for attractors of the edited parameter set, one search at a time, for a screen.

    It finds attractors that coexist with a stable equilibrium, then, unless the belt speed is
    finite, the friction below which there are none. An edit stops the search; late results are
    dropped.
    """

    def __init__(self, screen: "LabScreen") -> None:
        self._screen = screen
        self._key: Key | None = None
        self._job: Job | None = None
        self._waiting: Timer | None = None
        self._cache: OrderedDict[Key, Attractors] = OrderedDict()
        self._result: Coexistence | None = None

    def attractors(self, system: System, *, stable: bool) -> Attractors:
        """The known attractors beside the equilibrium; starts a search if it is incomplete."""
        key = (system, stable)
        if key != self._key:
            self.stop()
            self._key = key
            if key not in self._cache or not self._cache[key].searched:
                self._waiting = self._screen.set_timer(_PAUSE, self._begin)
        return self._cache.get(key, Attractors() if stable else Attractors(text=""))

    def stop(self) -> None:
        """Stop the search."""
        self._key = self._result = None
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

        def show(store: Callable[..., None], *args: object) -> None:
            self._screen.call_later(self._store, job, store, *args)

        def partial_result(result: "Coexistence") -> None:
            show(self._store_result, result, False)

        def search() -> None:
            from fivtui.orbits import coexistence
            from fivtui.safety import safe_friction

            if stable:
                outcome = compute_outcome(
                    lambda: coexistence(system, progress=job.report, on_found=partial_result)
                )
                if outcome.error:
                    show(self._store_error, outcome.error)
                elif outcome.result is not None:
                    show(self._store_result, outcome.result, True)
                else:
                    return
            p = system.parameters
            if p.v_belt is not None:
                show(self._store_safe, None)
                return
            safe = compute_outcome(
                lambda: safe_friction(p, separation=system.separation, progress=job.report)
            )
            if safe.result is not None or safe.error:
                show(self._store_safe, safe.result)

        self._screen.run_worker(
            search, name="search for limit cycles", thread=True, exit_on_error=False
        )

    def _store(self, job: Job, store: Callable[..., None], *args: object) -> None:
        # Ignore results if the parameters were edited since.
        if job is not self._job or self._key is None:
            return
        store(self._key, *args)
        while len(self._cache) > _CACHE_SIZE:
            self._cache.popitem(last=False)
        self._screen.show_search_result()

    def _store_error(self, key: Key, error: str) -> None:
        self._cache[key] = Attractors(f"search for limit cycles failed: {error}", complete=True)

    def _store_result(self, key: Key, result: "Coexistence", complete: bool) -> None:
        from fivtui.orbits import coexistence_phrase

        self._result = result
        note = (result.warning or "") if complete else ""
        self._cache[key] = Attractors(coexistence_phrase(result), note, result.coexists, complete)

    def _store_safe(self, key: Key, safe: "SafeFriction | None") -> None:
        self._job = None
        before = self._cache.get(key, Attractors(text=""))
        self._cache[key] = replace(before, safe=safe, searched=True)
        if safe is None or not before.text:
            return
        from fivtui.orbits import coexistence_phrase
        from fivtui.safety import coexistence_here

        if self._result is not None and self._result.coexists and safe.others:
            since = f" from μ = {safe.others[0].mu:.4g}"
            self._cache[key] = replace(
                self._cache[key], text=coexistence_phrase(self._result, since)
            )
        elif sentence := coexistence_here(safe):
            self._cache[key] = replace(self._cache[key], text=sentence, coexists=True)

"""Computes the gauges of μ and of the edited parameter for the verdict.

A gauge shows the zones of a parameter in which the slider is safe or squeals. Zones by eigenvalues
are shown at once; a thread finds the zones that large disturbances limit.
"""

from typing import TYPE_CHECKING, Final, NamedTuple

from textual.cache import LRUCache

from fivtui.equilibrium import Stability, mu_scan_end
from fivtui.model import ALL_PARAMETERS, ComputationError, InputError, System
from fivtui.safety import Zone, Zones, linear_zones, zones_of_safe_friction
from fivtui.tui.lab.verdict.gauge import Gauge, round_range
from fivtui.tui.session import FIELDS, Attractors, Job, compute_outcome

from .controller import Controller

if TYPE_CHECKING:
    from fivtui.tui.lab.screen import LabScreen

# Number of ranges whose zones are cached.
_CACHE_SIZE: Final = 64
_MU: Final = "mu"
_STATIC_FRICTION: Final = "mu_s"
# The parameter of the second gauge, until a parameter other than μ is edited.
_DEFAULT_SECOND: Final = "F"


class _GaugeRange(NamedTuple):
    # A range of the parameter `name`. Its value in `system` is `high`, which is always allowed, so
    # that equal ranges are equal keys of the cache whatever the edited value is.
    system: System
    name: str
    low: float
    high: float


class GaugeController(Controller[Job]):
    """Computes the gauges of the edited scene, one range after the other."""

    def __init__(self, screen: "LabScreen") -> None:
        super().__init__(screen)
        self._second, self.second_is_focused = _DEFAULT_SECOND, False
        # Zones that were computed; None if the computation failed.
        self._cache: LRUCache[_GaugeRange, Zones | None] = LRUCache(_CACHE_SIZE)
        # Lower and upper end of the displayed ranges by parameter; that of a dragged one stays.
        self._ranges: dict[str, tuple[float, float]] = {}
        # The ranges to compute, and the one that is being computed.
        self._queue: list[_GaugeRange] = []
        self._running: _GaugeRange | None = None
        # The parameter whose marker the mouse drags, or empty.
        self.dragged = ""

    def focus(self, name: str) -> None:
        """Make the parameter of a focused field that of the second gauge."""
        self.second_is_focused = name in ALL_PARAMETERS and name != _MU
        if self.second_is_focused:
            self._second = name

    def gauges(
        self, stability: Stability, attractors: Attractors, *, both: bool
    ) -> list[Gauge | str]:
        """The gauge of μ, and if `both`, that of the parameter edited last.

        A text replaces a gauge that cannot be drawn.
        """
        over_time = [name for name, _ in self._session.over_time]
        if over_time:
            self.stop()
            verb = "changes" if len(over_time) == 1 else "change"
            change = f"{', '.join(over_time)} {verb} over time"
            return [f"no zones: {change}; Run computes the motion"]
        # Optional parameters, such as the belt speed, may have no value.
        values = stability.parameters.as_dict()
        second = _DEFAULT_SECOND if values.get(self._second) is None else self._second
        self._queue = []
        names = (_MU, second) if both else (_MU,)
        gauges = [self._gauge(name, stability, attractors) for name in names]
        if self._running not in self._queue:
            self._start_next()
        return gauges

    def _gauge(self, name: str, stability: Stability, attractors: Attractors) -> Gauge | str:
        field, safe_friction = FIELDS[name], attractors.safe
        value = getattr(stability.parameters, name)
        try:
            gauge_range = self._gauge_range(name, value, stability)
            low, high = gauge_range.low, gauge_range.high
            zones = self._cache.get(gauge_range)
            if name == _MU and safe_friction is not None:
                zones = zones_of_safe_friction(safe_friction, low, high)
            elif gauge_range not in self._cache:
                self._queue.append(gauge_range)
            if zones is None:
                zones = linear_zones(gauge_range.system, name, low, high)
        except (ComputationError, InputError) as error:
            return f"{field.symbol}: no zones: {error}"
        is_unsafe = safe_friction is not None and stability.parameters.mu > safe_friction.safe_to
        if is_unsafe and name != _MU and zones.at(value) is Zone.SAFE:
            # The search over μ contradicts these zones, so do not show them as safe.
            zones = zones.without_safe()
        unit = f" ({field.unit})" if field.unit else ""
        text, searching = self._session.texts[name].strip(), gauge_range in self._queue
        basis = _methods_text(stability, searched=name == _MU and safe_friction is not None)
        return Gauge(f"{field.symbol}{unit}", zones, value, text, searching, basis)

    def _gauge_range(self, name: str, value: float, stability: Stability) -> _GaugeRange:
        parameters, spec = stability.parameters, ALL_PARAMETERS[name]
        if name == _MU and self.dragged != _MU:
            self._ranges[_MU] = 0.0, mu_scan_end(stability)
        elif self.dragged != name:
            # Static friction is at least the sliding friction.
            lower = parameters.mu if name == _STATIC_FRICTION else spec.lower
            self._ranges[name] = round_range(value, lower, spec.upper)
        low, high = self._ranges[name]
        return _GaugeRange(stability.system.with_values({name: high}), name, low, high)

    def _start_next(self) -> None:
        # Compute the zones of the first range that is queued.
        super().stop()
        self._running = next(iter(self._queue), None)
        if self._running is None:
            return
        gauge_range, self._job = self._running, Job()
        report = self._job.report

        def compute() -> None:
            from fivtui.safety import safety_zones

            # Wait until the screen has responded to the edit.
            report(0.0)
            outcome = compute_outcome(lambda: safety_zones(*gauge_range, progress=report))
            if outcome.result is not None or outcome.error:
                self._screen.call_later(self.store, gauge_range, outcome.result)

        self._screen.run_in_thread("zones over a parameter", compute)

    def store(self, gauge_range: _GaugeRange, zones: Zones | None) -> None:
        """Cache the zones of a range, even if the parameters were edited since."""
        self._cache[gauge_range] = zones
        if self._running == gauge_range:
            self._running = None
        self._screen.show_verdict()

    def stop(self) -> None:
        """Stop computing zones."""
        super().stop()
        self._queue, self._running = [], None


def _methods_text(stability: Stability, *, searched: bool) -> str:
    # Names the methods that found the zones.
    if stability.parameters.v_belt is not None:
        return "zones by eigenvalues; large disturbances are not searched at finite belt speed"
    search = " and a global search" if searched else ""
    return f"zones by eigenvalues, continuation{search}"

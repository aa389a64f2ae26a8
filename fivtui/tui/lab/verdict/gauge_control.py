"""Computes the gauges of the edited parameter and of μ; a thread follows limit cycles."""

from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, scan_top
from fivtui.model import ALL_PARAMETERS, ComputationError, InputError, System
from fivtui.safety import Zone, Zones, linear_zones, zones_of_verdict
from fivtui.tui.session import FIELDS, Attractors, Job, compute_outcome

from .gauge import Gauge, round_range

if TYPE_CHECKING:
    from fivtui.tui.lab.screen import LabScreen

# Number of ranges whose zones are cached.
_CACHE_SIZE: Final = 64
_MU: Final = "mu"
_STATIC_FRICTION: Final = "mu_s"
# The parameter of the second gauge, until a parameter other than μ is edited.
_SECOND: Final = "F"
# Least ratio of the end of the needed range to the end of the range that is kept.
_MIN_FILL: Final = 0.4


@dataclass(frozen=True, slots=True)
class _GaugeRange:
    # Key of cached zones: a range of a parameter, and the system with the parameter at its end.
    system: System
    name: str
    low: float
    high: float


class GaugeController:
    """Computes the gauges of the edited scene, one range after the other."""

    def __init__(self, screen: "LabScreen") -> None:
        self._screen, self._session = screen, screen.session
        self._focused, self._second_name = _MU, _SECOND
        self._cache: OrderedDict[_GaugeRange, Zones | None] = OrderedDict()
        self._ranges: dict[str, tuple[float, float]] = {}
        self._queue: list[_GaugeRange] = []
        self._running: tuple[_GaugeRange, Job] | None = None

    def focus(self, name: str) -> None:
        """Set the parameter of the gauge: that of the focused field, or else μ."""
        self._focused = name if name in ALL_PARAMETERS else _MU
        if self._focused != _MU:
            self._second_name = self._focused

    def gauges(self, result: Stability, attractors: Attractors, *, both: bool) -> list[Gauge | str]:
        """The gauge of the edited parameter, or if `both`, of μ and of the second parameter."""
        over_time = [name for name, _ in self._session.over_time]
        if over_time:
            self.stop()
            change = f"{', '.join(over_time)} {_change_verb(over_time)} over time"
            return [f"no zones: {change}; F5 runs the scene"]
        parameters = result.parameters
        second = _SECOND if getattr(parameters, self._second_name) is None else self._second_name
        focused_name = _MU if getattr(parameters, self._focused) is None else self._focused
        names = [_MU, second] if both else [focused_name]
        self._queue = []
        gauges = [self._gauge_or_error(name, result, attractors) for name in dict.fromkeys(names)]
        self._start_next()
        return gauges

    def _gauge_or_error(self, name: str, result: Stability, attractors: Attractors) -> Gauge | str:
        try:
            return self._gauge(name, result, attractors)
        except (ComputationError, InputError) as error:
            return f"{FIELDS[name].symbol}: no zones: {error}"

    def _gauge(self, name: str, result: Stability, attractors: Attractors) -> Gauge | str:
        value = getattr(result.parameters, name)
        key = self._gauge_range(name, value, result)
        safe = attractors.safe if name == _MU else None
        zones, searching = self._cache.get(key), False
        if safe is not None:
            zones = zones_of_verdict(safe, key.low, key.high)
        elif key not in self._cache:
            self._queue.append(key)
            searching = True
        if zones is None:
            zones = linear_zones(key.system, key.name, key.low, key.high)
        is_refuted = attractors.safe is not None and result.parameters.mu > attractors.safe.safe_to
        if is_refuted and name != _MU and zones.at(value) is Zone.SAFE:
            # The search contradicts the continuation, so do not show its safe zones.
            zones = zones.without_safe()
        field = FIELDS[name]
        unit = f" ({field.unit})" if field.unit else ""
        text, basis = self._session.texts[name].strip(), _methods_text(result, safe is not None)
        return Gauge(f"{field.symbol}{unit}", zones, value, text, searching, basis)

    def _gauge_range(self, name: str, value: float, result: Stability) -> _GaugeRange:
        parameters = result.parameters
        if name == _MU:
            low, high = 0.0, scan_top(result)
        else:
            low, high = round_range(value, ALL_PARAMETERS[name].lower, ALL_PARAMETERS[name].upper)
        # Keep a range that is wide enough but not too wide, so that the gauge does not jump.
        old = self._ranges.get(name)
        if old is not None and old[0] <= low and _MIN_FILL * old[1] <= high <= old[1]:
            low, high = old
        self._ranges[name] = low, high
        # Static friction is at least the sliding friction.
        if name == _MU and parameters.mu_s is not None:
            high = min(high, parameters.mu_s)
        if name == _STATIC_FRICTION:
            low = max(low, parameters.mu)
        return _GaugeRange(result.system.with_values({name: high}), name, low, high)

    def _start_next(self) -> None:
        if self._running is not None:
            key, job = self._running
            if key in self._queue:
                return
            job.stop()
            self._running = None
        if not self._queue:
            return
        key, job = self._queue[0], Job()
        self._running = key, job

        def compute() -> None:
            from fivtui.safety import safety_zones

            job.report(0.0)
            outcome = compute_outcome(
                lambda: safety_zones(key.system, key.name, key.low, key.high, progress=job.report)
            )
            if outcome.result is not None or outcome.error:
                self._screen.call_later(self.store, key, outcome.result)

        self._screen.run_worker(
            compute, name="zones over a parameter", thread=True, exit_on_error=False
        )

    def store(self, key: _GaugeRange, zones: Zones | None) -> None:
        """Cache the zones of a range, even if the parameters were edited since."""
        self._cache[key] = zones
        while len(self._cache) > _CACHE_SIZE:
            self._cache.popitem(last=False)
        if self._running is not None and self._running[0] == key:
            self._running = None
        self._screen.show_verdict()

    def stop(self) -> None:
        """Stop computing zones."""
        self._queue = []
        if self._running is not None:
            self._running[1].stop()
            self._running = None


def _methods_text(result: Stability, searched: bool) -> str:
    # Names the methods that found the zones.
    if result.parameters.v_belt is not None:
        return "zones by eigenvalues; large disturbances are not searched at finite belt speed"
    search = " and a global search" if searched else ""
    return f"zones by eigenvalues, continuation{search}"


def _change_verb(names: list[str]) -> str:
    return "changes" if len(names) == 1 else "change"

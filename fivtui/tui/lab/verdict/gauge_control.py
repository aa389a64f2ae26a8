"""Gauges over the parameter being edited, and over μ: limit cycles are followed in a thread."""

from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from fivtui.equilibrium import Stability, scan_top
from fivtui.model import ALL_PARAMETERS, ComputationError, InputError, System
from fivtui.safety import Zone, Zones, linear_zones, searched_zones
from fivtui.tui.session import FIELDS, Coexisting, Job, outcome_of

from .gauge import Gauge, round_span

if TYPE_CHECKING:
    from fivtui.tui.lab.screen import LabScreen

# Number of ranges whose zones are cached.
_REMEMBERED: Final = 64
_MU: Final = "mu"
_STATIC: Final = "mu_s"
# Beside μ as long as no other parameter was edited.
_FIRST: Final = "F"
# A range stays if what is needed is this part of it at least.
_LEAST_PART: Final = 0.4


@dataclass(frozen=True, slots=True)
class _GaugeRange:
    # What zones depend on; the value of the parameter itself does not matter.
    system: System
    name: str
    low: float
    high: float


class GaugeController:
    """Computes the gauges of the edited scene for a screen, one range after the other."""

    def __init__(self, screen: "LabScreen") -> None:
        self._screen, self._session = screen, screen.session
        self._focused, self._other = _MU, _FIRST
        self._known: OrderedDict[_GaugeRange, Zones | None] = OrderedDict()
        self._ranges: dict[str, tuple[float, float]] = {}
        self._wanted: list[_GaugeRange] = []
        self._running: tuple[_GaugeRange, Job] | None = None

    def focus(self, name: str) -> None:
        """Take the parameter of the focused field; of a field that is none, μ."""
        self._focused = name if name in ALL_PARAMETERS else _MU
        if self._focused != _MU:
            self._other = self._focused

    def gauges(self, found: Stability, coexisting: Coexisting, *, both: bool) -> list[Gauge | str]:
        """The gauge over the parameter being edited, or both: over μ, and over the last other."""
        over_time = [name for name, _ in self._session.over_time]
        if over_time:
            self.stop()
            changing = f"{', '.join(over_time)} {_verb(over_time)} over time"
            return [f"no zones: {changing}; F5 shows what happens"]
        p = found.parameters
        other = _FIRST if getattr(p, self._other) is None else self._other
        focused = _MU if getattr(p, self._focused) is None else self._focused
        names = [_MU, other] if both else [focused]
        self._wanted = []
        shown = [self._shown(name, found, coexisting) for name in dict.fromkeys(names)]
        self._begin()
        return shown

    def _shown(self, name: str, found: Stability, coexisting: Coexisting) -> Gauge | str:
        try:
            return self._gauge(name, found, coexisting)
        except (ComputationError, InputError) as error:
            return f"{FIELDS[name].symbol}: no zones: {error}"

    def _gauge(self, name: str, found: Stability, coexisting: Coexisting) -> Gauge | str:
        value = getattr(found.parameters, name)
        key = self._key(name, value, found)
        searched = coexisting.safe if name == _MU else None
        zones, searching = self._known.get(key), False
        if searched is not None:
            zones = searched_zones(searched, key.low, key.high)
        elif key not in self._known:
            self._wanted.append(key)
            searching = True
        if zones is None:
            zones = linear_zones(key.system, key.name, key.low, key.high)
        refuted = coexisting.safe is not None and found.parameters.mu > coexisting.safe.safe_to
        if refuted and name != _MU and zones.at(value) is Zone.SAFE:
            # The search contradicts continuation here, so nowhere is that alone to be relied on.
            zones = zones.without_safe()
        field = FIELDS[name]
        unit = f" ({field.unit})" if field.unit else ""
        text, basis = self._session.texts[name].strip(), _basis(found, searched is not None)
        return Gauge(f"{field.symbol}{unit}", zones, value, text, searching, basis)

    def _key(self, name: str, value: float, found: Stability) -> _GaugeRange:
        p = found.parameters
        if name == _MU:
            low, high = 0.0, scan_top(found)
        else:
            low, high = round_span(value, ALL_PARAMETERS[name].lower, ALL_PARAMETERS[name].upper)
        # A range that is not much too wide stays: the gauge does not jump while a value changes.
        before = self._ranges.get(name)
        if before is not None and before[0] <= low and _LEAST_PART * before[1] <= high <= before[1]:
            low, high = before
        self._ranges[name] = low, high
        # Static friction is at least that of sliding.
        if name == _MU and p.mu_s is not None:
            high = min(high, p.mu_s)
        if name == _STATIC:
            low = max(low, p.mu)
        return _GaugeRange(found.system.with_values({name: high}), name, low, high)

    def _begin(self) -> None:
        if self._running is not None:
            key, job = self._running
            if key in self._wanted:
                return
            job.stop()
            self._running = None
        if not self._wanted:
            return
        key, job = self._wanted[0], Job()
        self._running = key, job

        def compute() -> None:
            from fivtui.safety import safety_zones

            job.report(0.0)
            outcome = outcome_of(
                lambda: safety_zones(key.system, key.name, key.low, key.high, progress=job.report)
            )
            if outcome.result is not None or outcome.error:
                self._screen.call_later(self.take, key, outcome.result)

        self._screen.run_worker(
            compute, name="zones over a parameter", thread=True, exit_on_error=False
        )

    def take(self, key: _GaugeRange, zones: Zones | None) -> None:
        """Store zones, perhaps of parameters that were edited since."""
        self._known[key] = zones
        while len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)
        if self._running is not None and self._running[0] == key:
            self._running = None
        self._screen.show_verdict()

    def stop(self) -> None:
        """Stop the computation."""
        self._wanted = []
        if self._running is not None:
            self._running[1].stop()
            self._running = None


def _basis(found: Stability, searched: bool) -> str:
    # What the zones rest on.
    if found.parameters.v_belt is not None:
        return "zones by eigenvalues; large disturbances are not searched at finite belt speed"
    more = " and a global search" if searched else ""
    return f"zones by eigenvalues, continuation{more}"


def _verb(names: list[str]) -> str:
    return "changes" if len(names) == 1 else "change"

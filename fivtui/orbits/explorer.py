"""Attractors: which motion a start ends in, such as the equilibrium or a limit cycle.

An explorer integrates the motion in legs of equal duration. After each leg it tests whether the
motion decays, or returns to nearly the same state. A return is a state at which the motion passes a
section, such as y = 0 upwards.
"""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fivtui.kernel import stepping_kernel
from fivtui.model import (
    IN_CONTACT,
    ComputationError,
    Mode,
    Progress,
    State,
    System,
    mode_of,
    static_start,
)
from fivtui.results import to_data
from fivtui.transient import Kernel, Request, Start, Transient, integrate, resolve_start

from .curves.arclength import SILENT_PROGRESS
from .decay import DecayRegion
from .rest import length_scale, reference_equilibrium, slowest_period, sticks_forever
from .shooting import PeriodicOrbit, Section, shoot

# Duration of a leg, in periods of the slowest linear mode.
_LEG_PERIODS: Final = 16.0
# Upper bounds of the legs and of the integration steps of a motion.
_MAX_LEGS: Final = 128
_MAX_STEPS: Final = 200_000
_TOL: Final = 1e-11
# Extent, relative to that of the start, up to which a motion is at rest without proven decay. A
# motion that starts exactly at an unstable equilibrium also stays there.
_REST_EXTENT: Final = 1e-9
# Displacement of an unbounded motion, relative to the start and to the characteristic length.
UNBOUNDED_EXTENT: Final = 1e6
# Distance between two returns to the section below which shooting begins, and greatest distance of
# recent returns from the orbit found, relative to the size of the motion.
_RECURRENCE_DISTANCE: Final = 0.01
_ORBIT_DISTANCE: Final = 0.05
# Distance of returns from a known orbit, relative to the motion, below which it is the same orbit.
_KNOWN_ORBIT_DISTANCE: Final = 1e-2
# Greatest number of returns in a period, and least number in a leg that shows such a period.
_MAX_RETURNS: Final = 8
_LEAST_RETURNS: Final = _MAX_RETURNS + 2
# Relative difference below which two cycles are equal.
_CYCLE_TOLERANCE: Final = 1e-6
# Samples per period of the slowest mode among which lowest points are found.
_SAMPLES_PER_PERIOD: Final = 64
# Longest leg, relative to the first, where sticks are long.
_MAX_LEG_GROWTH: Final = 1024.0
# Duration of a stick, relative to the longest one in a leg, below which it is ignored.
_SHORT_STICK: Final = 1e-3
# Starts at rest above and below the equilibrium, in characteristic lengths.
_OFFSETS: Final = (1e-3, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, -0.3, -1.0, -3.0)


class Kind(StrEnum):
    """Kinds of attractors."""

    EQUILIBRIUM = "equilibrium"
    CONTACT_CYCLE = "contact limit cycle"
    SEPARATING_CYCLE = "separating limit cycle"
    UNBOUNDED = "unbounded"
    UNSETTLED = "not settled"
    STICK_SLIP_CYCLE = "stick-slip limit cycle"
    STICK = "rest by stick"


# Kinds of attractors without motion.
AT_REST: Final = (Kind.EQUILIBRIUM, Kind.STICK)

# Fields of an orbit that JSON does not copy: three are converted, the residual is left out.
_UNCOPIED_FIELDS: Final = {"section", "start", "multipliers", "residual"}
_ORBIT_DATA: Final = [
    field.name for field in fields(PeriodicOrbit) if field.name not in _UNCOPIED_FIELDS
]


@dataclass(frozen=True, slots=True)
class Attractor:
    """An attractor, with its orbit if it is periodic.

    Attributes
    ----------
    kind : Kind
        `Kind.STICK` if the slider sticks for ever to a belt at rest, which has a range of
        equilibria. `Kind.STICK_SLIP_CYCLE` if a cycle sticks, whether or not it also separates.
        `Kind.UNSETTLED` if the motion neither came to rest, nor became periodic, nor diverged in
        the time limit: it settles very slowly, or is quasi-periodic or chaotic.
    orbit : PeriodicOrbit or None
        The limit cycle, confirmed by shooting.
    """

    kind: Kind
    orbit: PeriodicOrbit | None = None

    @property
    def half_range(self) -> float | None:
        """Half peak-to-peak of y, m; zero at rest, None without orbit."""
        if self.kind in AT_REST:
            return 0.0
        return None if self.orbit is None else self.orbit.half_range

    @property
    def description(self) -> str:
        """Kind, period and size as a phrase."""
        if self.orbit is None:
            return str(self.kind)
        size = f"half peak-to-peak {self.half_range:.6g} m"
        return f"{self.kind}, period {self.orbit.period:.6g} s, {size}"

    def to_dict(self) -> dict[str, Any]:
        """The attractor as data for JSON, in SI units.

        Keys are ``kind`` and ``half_range``, and of a limit cycle ``period``, ``start`` (x, ẋ, y, ẏ
        where the period begins), ``section`` (what begins it: ``lift-off``, ``lowest-point`` or
        ``stick``), ``y_min``, ``y_max``, ``x_abs``, ``vx_max``, ``force_max`` (of the contact),
        ``separations``, ``separated_time``, ``sticks`` and ``stick_time`` per period, and
        ``floquet_multipliers`` as pairs of real and imaginary part.
        """
        data: dict[str, Any] = {"kind": self.kind, "half_range": self.half_range}
        if self.orbit is not None:
            data |= {name: getattr(self.orbit, name) for name in _ORBIT_DATA}
            data |= {
                "section": self.orbit.section.name.lower().replace("_", "-"),
                "start": self.orbit.start,
                "floquet_multipliers": self.orbit.multipliers.tolist(),
            }
        json_data: dict[str, Any] = to_data(data)
        return json_data

    def equals(self, attractor: "Attractor") -> bool:
        """Whether both are the same attractor."""
        if self.kind is not attractor.kind:
            return False
        if self.orbit is None or attractor.orbit is None:
            return True
        return bool(
            np.allclose(_features(self.orbit), _features(attractor.orbit), _CYCLE_TOLERANCE, 0.0)
        )


def _features(orbit: PeriodicOrbit) -> tuple[float, ...]:
    # Quantities that do not depend on the start of the period.
    return (orbit.period, orbit.y_min, orbit.y_max, orbit.x_abs, orbit.vx_max)


class _Returns(NamedTuple):
    # Times and states at which a motion passes a section.
    section: Section
    times: NDArray[np.float64]
    states: NDArray[np.float64]


class Explorer:
    """Follows motions of one parameter set to their attractors; remembers the limit cycles."""

    def __init__(
        self,
        system: System,
        *,
        kernel: Kernel | None = None,
        work: Progress = SILENT_PROGRESS,
    ) -> None:
        self.system, self._kernel, self._work = system, kernel or stepping_kernel(), work
        p, separation, point = system.parameters, system.separation, reference_equilibrium(system)
        belt_at_rest = p.v_belt == 0.0 and point.mode in IN_CONTACT
        self.decay_region = None if belt_at_rest else DecayRegion(system, point)
        self.slowest_period = slowest_period(p)
        self._leg_time = _LEG_PERIODS * self.slowest_period
        # Known orbits, stable and unstable: none is computed twice.
        self._orbits: list[PeriodicOrbit] = []
        # On a belt of finite speed, with `v_belt`, friction depends on the sliding velocity.
        self._is_linear = p.k_nl == 0.0 and not separation and p.v_belt is None
        self.length = length_scale(system)
        self.rest: State = (point.x, 0.0, point.y, 0.0)

    @property
    def equilibrium_attracts(self) -> bool:
        """Whether the equilibrium is stable by its eigenvalues, with a region of proven decay."""
        return self.decay_region is not None and self.decay_region.radius > 0.0

    def reach(self, start: Start, max_legs: int = _MAX_LEGS) -> Attractor:
        """Follow the motion from a start to its attractor.

        A motion reaches the equilibrium when a Lyapunov function proves its decay, and rest by
        stick when the slider cannot slip again. It reaches a limit cycle when Newton's method finds
        a stable cycle close to it.
        """
        state = resolve_start(self.system, start)
        extent, steps, leg_time = self.extent(state), 0, self._leg_time
        for _ in range(max_legs):
            if steps > _MAX_STEPS:
                break
            region = self.decay_region
            if self.comes_to_rest(state):
                return Attractor(Kind.STICK if region is None else Kind.EQUILIBRIUM)
            if region is not None:
                if self.extent(state) <= _REST_EXTENT * extent:
                    return Attractor(Kind.EQUILIBRIUM)
                if self._is_linear and region.unstable:
                    return Attractor(Kind.UNBOUNDED)
            # Dense samples give the motion as a function of time: `run.solution`.
            request = Request(
                self.system,
                t_end=leg_time,
                tol=_TOL,
                start=state,
                samples="dense",
                kernel=self._kernel,
            )
            run = integrate(request, progress=lambda _fraction: self._work.should_continue())
            steps += run.stats.steps
            final = run.final
            state = (final.x, final.vx, final.y, final.vy)
            if max(run.peak.y_abs, run.peak.x_abs) > UNBOUNDED_EXTENT * max(self.length, extent):
                return Attractor(Kind.UNBOUNDED)
            returns = _find_returns(run)
            if 0 < returns.times.size < _LEAST_RETURNS and returns.section is Section.STICK:
                # Sticks on a slow belt are long: a leg has too few returns.
                leg_time = min(2.0 * leg_time, _MAX_LEG_GROWTH * self._leg_time)
                continue
            cycle = self._find_cycle(returns)
            if cycle is not None:
                return cycle
        return Attractor(Kind.UNSETTLED)

    def comes_to_rest(self, state: State) -> bool:
        """Whether the motion from a state is proven to come to rest."""
        if self.decay_region is not None:
            return self.decay_region.contains(state)
        p, separation = self.system.parameters, self.system.separation
        is_stuck = mode_of(p, state, separation=separation) is Mode.STICK
        return is_stuck and sticks_forever(p, state)

    def extent(self, state: State) -> float:
        """Distance from the equilibrium; velocities are over the slowest angular frequency."""
        deviation = np.subtract(state, self.rest)
        deviation[1::2] *= self.slowest_period / (2.0 * np.pi)
        return float(np.linalg.norm(deviation))

    def _find_cycle(self, returns: _Returns) -> Attractor | None:
        # The stable limit cycle near the returns of a leg; None if they are not nearly periodic.
        section, times, states = returns
        if times.size < _LEAST_RETURNS:
            return None
        # The states of a cycle at its returns hardly differ, so that the distance from rest counts.
        size = np.ptp(states, axis=0).max(initial=0.0) + np.abs(states - self.rest).max()
        recent = states[-_MAX_RETURNS:]
        for orbit in self._orbits:
            if orbit.section is section and _distance(recent, orbit) < _KNOWN_ORBIT_DISTANCE * size:
                return _cycle_attractor(orbit) if orbit.stable else None
        latest = states[-1]
        # The period may span several returns.
        for count in range(1, _MAX_RETURNS + 1):
            if np.abs(latest - states[-1 - count]).max() > _RECURRENCE_DISTANCE * size:
                continue
            x, vx, y, vy = latest
            period = float(times[-1] - times[-1 - count])
            try:
                orbit = shoot(self.system, (x, vx, y, vy), period, section, work=self._work)
            except ComputationError:
                return None
            if _distance(recent, orbit) > _ORBIT_DISTANCE * size:
                return None
            self._orbits.append(orbit)
            if orbit.stable:
                return _cycle_attractor(orbit)
        return None


def _distance(states: NDArray[np.float64], orbit: PeriodicOrbit) -> float:
    # Least distance of states from the start of an orbit.
    return float(np.abs(states - orbit.start).max(axis=1).min())


def _cycle_attractor(orbit: PeriodicOrbit) -> Attractor:
    if orbit.sticks > 0:
        return Attractor(Kind.STICK_SLIP_CYCLE, orbit)
    separates = orbit.separations > 0
    return Attractor(Kind.SEPARATING_CYCLE if separates else Kind.CONTACT_CYCLE, orbit)


def _find_returns(run: Transient) -> _Returns:
    # The returns in the second half of a leg: the middles of its sticks if there are any, else its
    # separations, else its lowest points.
    solution, t_end = run.solution, run.t_end
    half_time = 0.5 * t_end
    sticks = np.array(
        [(begin, end) for begin, end in run.stick_intervals if begin > half_time and end < t_end]
    )
    if sticks.size:
        durations = sticks[:, 1] - sticks[:, 0]
        times = sticks[durations > _SHORT_STICK * durations.max()].mean(axis=1)
        return _Returns(Section.STICK, times, _states(run, times))
    # Separations and reattachments alternate.
    first_separation = 0 if run.first_mode in IN_CONTACT else 1
    separation_times = run.switch_times[first_separation::2]
    times = separation_times[separation_times > half_time]
    if times.size:
        return _Returns(Section.LIFT_OFF, times, _states(run, times))
    assert solution is not None  # noqa: S101
    samples = np.linspace(half_time, t_end, int(_LEG_PERIODS) * _SAMPLES_PER_PERIOD)
    vy = solution(samples).vy
    before = np.flatnonzero((vy[:-1] < 0.0) & (vy[1:] >= 0.0))
    # Linear interpolation of the zero of ẏ between two samples.
    share = vy[before] / (vy[before] - vy[before + 1])
    times = samples[before] + share * (samples[before + 1] - samples[before])
    return _Returns(Section.LOWEST_POINT, times, _states(run, times))


def _states(run: Transient, times: NDArray[np.float64]) -> NDArray[np.float64]:
    # States of a run at times, shape (n, 4).
    if not times.size:
        return np.empty((0, 4))
    assert run.solution is not None  # noqa: S101
    states = run.solution(times)
    return np.stack([states.x, states.vx, states.y, states.vy], axis=1)


def standard_starts(explorer: Explorer) -> list[State]:
    """Starts of a search: the static start, and starts at rest above and below the equilibrium.

    The static start is at rest at the equilibrium for μ = 0, before the belt moves. Offsets are
    from 1e-3 to 30 characteristic lengths.
    """
    x, _, y, _ = explorer.rest
    releases = [(x, 0.0, y + offset * explorer.length, 0.0) for offset in _OFFSETS]
    return [static_start(explorer.system), *releases]


def add_attractor(attractors: list[Attractor], reached: Attractor) -> int:
    """Add an attractor to a list unless it is in there; return its index."""
    for index, attractor in enumerate(attractors):
        if attractor.equals(reached):
            return index
    attractors.append(reached)
    return len(attractors) - 1

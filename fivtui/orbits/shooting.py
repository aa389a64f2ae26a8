"""Periodic orbits by shooting: Newton's method on the return map, with Floquet multipliers.

Unknowns are the state on a Poincaré section and the period. The derivative of the return map comes
from the variational equations: Newton's method converges quadratically and the
multipliers are those of the orbit itself. An orbit that sticks to the belt is closed from within
a stick: there deviations across v_r = 0 are lost, and one multiplier is exactly 0.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import Cancelled, ComputationError, Parameters, State, System
from fivtui.transient import START_SEEDS, Request, Variation, integrate, vary

_MOST_ITERATIONS: Final = 10
_CONVERGED: Final = 1e-11
# Tolerance of the runs over one period, and of the one that measures the orbit.
_FLOW_TOL: Final = 1e-13
_TOL: Final = 1e-12
_MOST_STEPS: Final = 200_000
# A period that leaves this range around its estimate belongs to another orbit.
_PERIOD_RANGE: Final = (0.5, 2.0)
# Velocity and acceleration times period, relative to the displacement: less than this is rest.
_AT_REST: Final = 1e-6
# The estimate may be several periods; the orbit then closes after a part of the time.
_MOST_PARTS: Final = 8
_PART_CLOSES: Final = 1e-8


class Section(Enum):
    """Where the return map begins; its value is the index of the state that is held there.

    Zero at a separation (y) and at a lowest point (ẏ); within a stick x stays what it is.
    """

    LIFT_OFF = 2
    LOWEST_POINT = 3
    STICK = 0


@dataclass(frozen=True, slots=True)
class PeriodicOrbit:
    """A periodic motion, over one period.

    Attributes
    ----------
    section : Section
        Where it starts: at a separation (y = 0, upwards), at a lowest point (ẏ = 0), or within a
        stick.
    start : State
        (x, ẋ, y, ẏ) there, m and m/s.
    period : float
        Period, s.
    multipliers : ndarray of complex, shape (3,)
        Floquet multipliers by falling size, without the trivial one along the orbit; exactly 0
        where a deviation is lost in a stick.
    y_min, y_max : float
        Lowest and highest point, m.
    x_abs : float
        Greatest |x|, m.
    vx_max : float
        Greatest ẋ, m/s: the least belt speed for which the orbit of a slider that always slides is
        valid.
    force_max : float
        Greatest contact force, N.
    separations : int
        Number of separations.
    separated_time : float
        Time off the belt, s.
    residual : float
        Distance between end and start, relative to the orbit's size.
    sticks : int
        Number of sticks.
    stick_time : float
        Time of stick, s.
    """

    section: Section
    start: State
    period: float
    multipliers: NDArray[np.complex128]
    y_min: float
    y_max: float
    x_abs: float
    vx_max: float
    force_max: float
    separations: int
    separated_time: float
    residual: float
    sticks: int = 0
    stick_time: float = 0.0

    @property
    def half_range(self) -> float:
        """Half peak-to-peak of y, m."""
        return 0.5 * (self.y_max - self.y_min)

    @property
    def stable(self) -> bool:
        """Whether neighbouring motions return: all multipliers are inside the unit circle."""
        return bool(np.abs(self.multipliers).max() < 1.0)


def shoot(
    system: System,
    guess: State,
    period: float,
    section: Section,
    *,
    go_on: Callable[[], bool] = lambda: True,
) -> PeriodicOrbit:
    """Find the periodic orbit close to a guess closed to about 1e-12 of its size."""
    p = system.parameters
    state, time = _on_belt(p, np.array(guess), section), period
    fixed = section.value
    held = guess[fixed] if section is Section.STICK else 0.0
    least, best = np.inf, None
    for _ in range(_MOST_ITERATIONS):
        there = _flow(system, state, time, go_on)
        missed = np.array(there.final) - state
        size = _sizes(state, time)
        residual = float(np.abs(missed / size).max()) + abs(state[fixed] - held) / size[fixed]
        if residual < least:
            least, best = residual, (state, time, there)
        elif least < _CONVERGED:
            break
        try:
            change = _newton(there, missed, fixed, float(state[fixed]) - held)
        except np.linalg.LinAlgError:
            break
        state, time = _on_belt(p, state + change[:4], section), time + float(change[4])
        if not (_PERIOD_RANGE[0] < time / period < _PERIOD_RANGE[1]):
            break
    if best is None or not least < _CONVERGED:
        raise ComputationError(
            f"no periodic orbit with a period of about {period:.6g} s was found",
            "follow the motion longer, or start nearer to the orbit",
        )
    state, time, there = best
    if np.abs(there.rate).max() * time < _AT_REST * np.abs(state).max():
        raise ComputationError(
            "shooting converged to the equilibrium", "start farther from the equilibrium"
        )
    for parts in range(_MOST_PARTS, 1, -1):
        part = _flow(system, state, time / parts, go_on)
        if np.abs((np.array(part.final) - state) / _sizes(state, time)).max() < _PART_CLOSES:
            time, there = time / parts, part
            break
    return _measured(system, state, time, (section, least, there))


def _on_belt(p: Parameters, state: NDArray[np.float64], section: Section) -> NDArray[np.float64]:
    # A slider that sticks has the speed of the belt, to the last bit.
    if section is Section.STICK:
        state[1] = p.v_belt
    return state


def _flow(
    system: System, state: NDArray[np.float64], time: float, go_on: Callable[[], bool]
) -> Variation:
    if not go_on():
        raise Cancelled
    request = Request(
        system,
        t_end=time,
        tol=_FLOW_TOL,
        start=state.tolist(),
        max_steps=_MOST_STEPS,
    )
    return vary(request, START_SEEDS)


def _newton(
    there: Variation, missed: NDArray[np.float64], fixed: int, off: float
) -> NDArray[np.float64]:
    # The change of state and period that closes the orbit and puts its start on the section.
    system = np.zeros((5, 5))
    system[:4, :4] = there.derivatives - np.eye(4)
    system[:4, 4] = there.rate
    system[4, fixed] = 1.0
    change: NDArray[np.float64] = np.linalg.solve(system, -np.append(missed, off))
    return change


def _measured(
    system: System,
    state: NDArray[np.float64],
    period: float,
    found: tuple[Section, float, Variation],
) -> PeriodicOrbit:
    section, residual, there = found
    state = state.copy()
    if section is not Section.STICK:
        state[section.value] = 0.0
    request = Request(
        system,
        t_end=period,
        tol=_TOL,
        start=state.tolist(),
    )
    run = integrate(request)
    return PeriodicOrbit(
        section=section,
        start=_as_state(state),
        period=float(period),
        multipliers=_nontrivial(np.linalg.eigvals(there.derivatives)),
        y_min=run.peak.y_min,
        y_max=run.peak.y_max,
        x_abs=run.peak.x_abs,
        vx_max=run.peak.vx_max,
        force_max=run.contact_force.max,
        # By rounding a separation at the start may recur at the end; reattachments do not.
        separations=run.events.reattachments,
        separated_time=run.events.separated_time,
        residual=float(residual),
        # The stick in which the period begins and ends is one.
        sticks=run.events.sticks - int(section is Section.STICK),
        stick_time=run.events.stick_time,
    )


def _nontrivial(multipliers: NDArray[np.generic]) -> NDArray[np.complex128]:
    values = multipliers.astype(np.complex128)
    others = np.delete(values, np.abs(values - 1.0).argmin())
    return others[np.argsort(-np.abs(others), kind="stable")]


def _sizes(state: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    # Scales of displacements and velocities.
    x, vx, y, vy = np.abs(state)
    speed = max(vx, vy, max(x, y) / period, np.finfo(float).tiny)
    length = max(x, y, speed * period / (2.0 * np.pi))
    return np.array([length, speed, length, speed])


def _as_state(values: NDArray[np.float64]) -> State:
    x, vx, y, vy = values.tolist()
    return (x, vx, y, vy)

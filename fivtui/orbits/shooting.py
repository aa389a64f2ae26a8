"""The periodic orbit near a motion: Newton's method on its return map, with Floquet multipliers.

The equations are those of the branches of cycles, with the start fixed on a section of the motion.
The period of an orbit that sticks to the belt begins within a stick. A stick cancels deviations of
ẋ from the belt speed, so that one multiplier is exactly 0.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, Progress, State, System
from fivtui.transient import Request, integrate

from .curves.arclength import PARAMETER, PERIOD, SILENT_PROGRESS, OrbitOnCurve
from .curves.branch_curve import BranchCurve, ParameterLine

# Tolerance of the run that measures the orbit.
_TOL: Final = 1e-12
# Range of the period, relative to its estimate. Periods outside belong to different orbits.
_PERIOD_RANGE: Final = (0.5, 2.0)
# Amplitude, relative to the displacements, below which an orbit is the equilibrium.
_MIN_AMPLITUDE: Final = 1e-7
# The estimate of the period may be a multiple of the period: greatest factor.
_MAX_PERIODS: Final = 8
# Relative distance from the start below which an orbit closes after a fraction of the estimate.
_CLOSURE_DISTANCE: Final = 1e-8


class Section(Enum):
    """The section of the return map; its value is the index of the fixed variable in (x, ẋ, y, ẏ).

    The fixed variable is zero at a separation (y) and at a lowest point (ẏ). Within a stick x keeps
    its value.
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
        if a stick cancels a deviation.
    y_min, y_max : float
        Lowest and highest point, m.
    x_abs : float
        Greatest |x|, m.
    vx_max : float
        Greatest ẋ, m/s. An orbit without stick, under friction that does not depend on the sliding
        speed, is the same on every belt faster than this.
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
    work: Progress = SILENT_PROGRESS,
) -> PeriodicOrbit:
    """Find the periodic orbit close to a guess, closed to about 1e-12 of its size."""
    state = np.array(guess)
    if section is Section.STICK:
        # A slider that sticks has exactly the belt speed.
        state[1] = system.parameters.v_belt
    else:
        state[section.value] = 0.0
    x, vx, y, vy = np.abs(state).tolist()
    length = max(x, y, max(vx, vy) * period / (2.0 * np.pi))
    # The orbit is the point at the system's μ of a branch along μ: `_orbit_on_section` fixes μ. The
    # range of μ only sets its unit.
    curve = ParameterLine(system, "mu", (0.0, 1.0), work).curve(length, period)
    unknowns = np.array([*state, period, system.parameters.mu])
    orbit = _orbit_on_section(curve, unknowns / curve.scales, section)
    # The unit of the period is its estimate.
    shortest, longest = _PERIOD_RANGE
    if orbit is None or not shortest < float(orbit.unknowns[PERIOD]) < longest:
        raise ComputationError(
            f"no periodic orbit with a period of about {period:.6g} s was found",
            "follow the motion longer, or start nearer to the orbit",
        )
    if curve.size(orbit) < _MIN_AMPLITUDE * np.abs(orbit.unknowns[:4]).max():
        raise ComputationError(
            "shooting converged to the equilibrium", "start farther from the equilibrium"
        )
    for factor in range(_MAX_PERIODS, 1, -1):
        if curve.orbits.return_distance(orbit, share=1.0 / factor) < _CLOSURE_DISTANCE:
            guess_of_one_period = orbit.unknowns.copy()
            guess_of_one_period[PERIOD] /= factor
            orbit = _orbit_on_section(curve, guess_of_one_period, section) or orbit
            break
    return _measure_orbit(system, curve, orbit, section)


def _orbit_on_section(
    curve: BranchCurve, guess: NDArray[np.float64], section: Section
) -> OrbitOnCurve | None:
    # The orbit near a guess, with its start on a section: the section's state and the parameter are
    # fixed.
    unit_vectors = np.eye(len(guess))
    return curve.orbits.solve(guess, unit_vectors[[section.value, PARAMETER]])


def _measure_orbit(
    system: System, curve: BranchCurve, orbit: OrbitOnCurve, section: Section
) -> PeriodicOrbit:
    # The orbit in SI units, with the quantities that an independent run over a period measures.
    x, vx, y, vy, period, _ = (orbit.unknowns * curve.scales).tolist()
    request = Request(system, t_end=period, tol=_TOL, start=(x, vx, y, vy))
    run = integrate(request)
    final = (run.final.x, run.final.vx, run.final.y, run.final.vy)
    deviation = np.array(final) / curve.scales[:4] - orbit.unknowns[:4]
    return PeriodicOrbit(
        section=section,
        start=(x, vx, y, vy),
        period=period,
        multipliers=curve.multipliers([orbit])[0],
        y_min=run.peak.y_min,
        y_max=run.peak.y_max,
        x_abs=run.peak.x_abs,
        vx_max=run.peak.vx_max,
        force_max=run.contact_force.max,
        # An orbit that starts at a separation, y = 0, ends at it too, and rounding may count both:
        # count reattachments.
        separations=run.events.reattachments,
        separated_time=run.events.separated_time,
        residual=float(np.abs(deviation).max() / np.abs(orbit.unknowns[:4]).max()),
        # The period begins and ends in the same stick.
        sticks=run.events.sticks - int(section is Section.STICK),
        stick_time=run.events.stick_time,
    )

"""Stability of the equilibrium: eigenvalues and critical friction (Eqs. 8 and 9 of the paper).

The scene in the summary of a result lists the parameters that differ from the base set, which has
the values of the paper, and the effects that are ignored.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    Equilibrium,
    Parameters,
    System,
    check_off_edge,
    equilibrium,
    jacobian,
    system_of,
)
from fivtui.results import Plottable, SystemResult, check_finite, scene_text, to_data

from .belt import CriticalSpeed, critical_mu_on_belt, critical_speeds
from .critical import CriticalMu, coalescence_mu, linear_critical_mu
from .modes import VibrationMode, vibration_modes

if TYPE_CHECKING:
    from fivtui.charts import Sheet

    from .scan import ModeScan

# Growth rates below this, relative to the fastest eigenvalue, are zero to rounding.
ROUNDING: Final = 1e-12
# Frequencies closer than this, relative to the fastest eigenvalue, have merged.
_MERGED_DISTANCE: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Margin:
    """Distance to the loss of stability; negative if the equilibrium is unstable.

    Attributes
    ----------
    mu : float or None
        Critical less actual friction coefficient; None without a critical friction coefficient.
    growth_rate : float
        Slowest decay of the modes: the growth rate with its sign changed, 1/s.
    """

    mu: float | None
    growth_rate: float


@dataclass(frozen=True, slots=True)
class Coalescence:
    """Distance between the two modes.

    Attributes
    ----------
    frequency_distance : float
        Greatest less smallest frequency of the modes, rad/s; zero if they have coalesced.
    mu : float or None
        Friction coefficient at which the undamped frequencies coalesce; None if they do not.
    """

    frequency_distance: float
    mu: float | None


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Stability(SystemResult, Plottable):
    """Stability of the equilibrium of one parameter set.

    Attributes
    ----------
    system : System
        The system, with `parameters` and `separation`.
    equilibrium : Equilibrium
        The point at which the system is linearised: `x` and `y`, m, and the contact force `P`, N.
    eigenvalues : ndarray of complex, shape (4,)
        λ in 1/s: growth rates and angular frequencies, by falling imaginary part; those of modes
        with the same frequency by falling growth rate.
    growth_rate : float
        Greatest real part, 1/s.
    stable : bool
        Whether the growth rate is negative beyond rounding.
    critical_mu : tuple of CriticalMu
        Every μ > 0 in range at which the growth rate changes sign, ascending.
    critical_speed : tuple of CriticalSpeed
        Every belt speed, in the direction of `v_belt`, at which sliding gains or loses stability,
        from slow to fast belts; none where friction does not depend on it.
    linear_critical_mu : float or None
        μ_c of the linear system (k_nl = 0); None if it has none.
    modes : tuple of VibrationMode
        Frequencies, damping ratios and shapes, by falling frequency.
    margin : Margin
        Distance to the loss of stability.
    coalescence : Coalescence
        Distance between the two modes, and where they meet.
    """

    system: System
    equilibrium: Equilibrium
    eigenvalues: NDArray[np.complex128]
    growth_rate: float
    stable: bool
    critical_mu: tuple[CriticalMu, ...]
    critical_speed: tuple[CriticalSpeed, ...]
    linear_critical_mu: float | None
    modes: tuple[VibrationMode, ...]
    margin: Margin
    coalescence: Coalescence

    def _summary(self) -> list[tuple[str, str]]:
        verdict = "stable" if self.stable else "unstable"
        critical = ", ".join(f"{change.mu:.6g}" for change in self.critical_mu) or "none"
        linear = "none" if self.linear_critical_mu is None else f"{self.linear_critical_mu:.6g}"
        return [
            ("scene", scene_text(self.system)),
            ("equilibrium", f"{verdict}, growth rate {self.growth_rate:.6g} 1/s"),
            ("frequencies", ", ".join(f"{mode.frequency:.6g} Hz" for mode in self.modes)),
            ("critical mu", f"{critical} (of the linear system {linear})"),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui stability --json`` prints, in SI units.

        Keys are ``equilibrium``, ``eigenvalues`` as pairs of real and imaginary part,
        ``growth_rate``, ``stable``, ``critical_mu``, ``critical_speed``, ``linear_critical_mu``,
        ``modes``, ``margin`` and ``coalescence``; frequencies in Hz, angular frequencies in rad/s.
        Raises `ComputationError` if a number is not finite.
        """
        point = self.equilibrium
        data: dict[str, Any] = to_data(
            {
                "equilibrium": {"x": point.x, "y": point.y, "P": point.P},
                "eigenvalues": self.eigenvalues.tolist(),
                "growth_rate": self.growth_rate,
                "stable": self.stable,
                "critical_mu": self.critical_mu,
                "critical_speed": self.critical_speed,
                "linear_critical_mu": self.linear_critical_mu,
                "modes": [mode.to_dict() for mode in self.modes],
                "margin": self.margin,
                "coalescence": self.coalescence,
            }
        )
        # No name precedes the keys in a message.
        check_finite(data, "", "use parameters of less extreme size")
        return data

    def modes_over_mu(self) -> "ModeScan":
        """Eigenvalues over μ, from 0 to beyond μ and every critical μ."""
        from .scan import mode_scan, mu_scan_end

        return mode_scan(self.system, mu_scan_end(self))

    def _sheet(self) -> "Sheet":
        from .charts import modes_sheet

        return modes_sheet(self, self.modes_over_mu())


def stability(parameters: Parameters | None = None, *, separation: bool = True) -> Stability:
    """Stability of the equilibrium: eigenvalues, modes, critical friction, margins.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameter set; the base set of the paper, ``Parameters()``, if not given.
    separation : bool
        Whether the slider can leave the belt; matters only for F < 0, a load that lifts it, and
        for F = 0.

    Returns
    -------
    Stability
        Eigenvalues, modes, growth rate, critical friction coefficients and margins.

    Raises
    ------
    InputError
        If `parameters` is not a `Parameters`.
    ComputationError
        If there is no equilibrium; at F = 0 with separation, where the equilibrium is at y = 0 and
        eigenvalues decide nothing.

    Examples
    --------
    >>> from fivtui import Parameters, stability
    >>> result = stability(Parameters(mu=0.3))
    >>> result.stable, round(result.critical_mu[0].mu, 4)
    (True, 0.4394)
    """
    system = system_of(parameters, separation)
    p, point, values = system.parameters, *_linearise(system)
    growth, stable = _judge_eigenvalues(values)
    critical = critical_mu_on_belt(system)
    modes = vibration_modes(p, point, values)
    frequencies = [mode.angular_frequency for mode in modes]
    return Stability(
        system=system,
        equilibrium=point,
        eigenvalues=values,
        growth_rate=growth,
        stable=stable,
        critical_mu=critical,
        critical_speed=critical_speeds(system),
        linear_critical_mu=_linear_critical_mu(p),
        modes=modes,
        margin=Margin(_mu_margin(p.mu, critical), -growth),
        coalescence=Coalescence(max(frequencies) - min(frequencies), coalescence_mu(system)),
    )


def _mu_margin(mu: float, critical: Sequence[CriticalMu]) -> float | None:
    # Distance of μ from the nearest critical μ, negative on its unstable side.
    if not critical:
        return None
    nearest = min(critical, key=lambda change: abs(change.mu - mu))
    return nearest.mu - mu if nearest.becomes == "unstable" else mu - nearest.mu


def _linear_critical_mu(p: Parameters) -> float | None:
    if p.v_belt is None:
        return linear_critical_mu(p)
    linear = p.with_values({"k_nl": 0.0})
    return next((critical.mu for critical in critical_mu_on_belt(System(linear))), None)


def growth_rate(system: System) -> float:
    """Greatest real part of the eigenvalues at the equilibrium, 1/s."""
    return float(_linearise(system)[1].real.max())


def growth_and_stability(system: System) -> tuple[float, bool]:
    """Growth rate, 1/s, and whether the equilibrium is stable, as in `Stability`."""
    return _judge_eigenvalues(_linearise(system)[1])


def _judge_eigenvalues(values: NDArray[np.complex128]) -> tuple[float, bool]:
    growth = float(values.real.max())
    return growth, growth < -ROUNDING * float(np.abs(values).max())


def _linearise(system: System) -> tuple[Equilibrium, NDArray[np.complex128]]:
    # The equilibrium and its eigenvalues.
    check_off_edge(system)
    point = equilibrium(system)
    matrix = jacobian(system.parameters, point.y, point.mode)
    return point, in_order(np.linalg.eigvals(np.array(matrix)).astype(np.complex128))


def in_order(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Eigenvalues by falling imaginary part, where these have merged by falling real part."""
    merged_distance = _MERGED_DISTANCE * np.abs(values).max()
    order = np.lexsort((-values.real, -np.rint(values.imag / merged_distance)), axis=-1)
    return np.take_along_axis(values, order, axis=-1)

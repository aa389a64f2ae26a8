"""A region around the equilibrium in which a Lyapunov function proves that motion decays.

The deviation from the equilibrium is V q with eigenvectors V and modal coordinates q. Linear motion
decays at least like e^{−σt}. The row w of V for y gives the height η = y − y_e = w q, hence
|η| ≤ |w| |q|. The cubic contact stiffness k_nl adds b n(η) with b = V⁻¹ (0, μ, 0, 1)ᵀ and
n = −k_nl (3 y_e η² + η³)/m. Hence

    d|q|/dt ≤ −σ |q| + |b| k_nl/m (3 |y_e| |w|² |q|² + |w|³ |q|³)

which is negative for all |q| below a root of a quadratic. With separation the region ends where the
slider would leave the belt, at y = 0.

Without v_belt the belt is always faster than the slider. With it the region ends where the slider
would have the belt speed, so that the sliding speed v = |v_belt − ẋ| is between 0 and 2 |v_belt|.
Linear motion then has the tangent of μ(v) at |v_belt|, the contact force P_e at the equilibrium,
and the tangent stiffness k_t of the contact. What they leave out of the friction force μ P is,
beside n(η), at most

    |μ″(0)|/2 ẋ² (|P_e| + k_t |η|) + |μ′(|v_belt|)| k_t |ẋ| |η|

The column of V⁻¹ for ẋ, divided by m, turns it into a rate of q. The friction law has to be convex,
with |μ″| decreasing with v: |μ″(0)| bounds |μ″|, and the greater of μ(0) and μ(2 |v_belt|) bounds
μ.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import (
    IN_CONTACT,
    Equilibrium,
    Parameters,
    State,
    System,
    depends_on_speed,
    friction_coefficient,
    friction_derivatives,
    friction_slope,
    is_on_edge,
    jacobian,
    sliding_friction_ratio,
    tangent_stiffness,
)

# Rounding of a growth rate, relative to the fastest eigenvalue.
_ROUNDING: Final = 1e-12
# Condition number of the eigenvectors above which the proof would suffer from rounding.
_MAX_CONDITION: Final = 1e8
_VX, _Y, _VY = 1, 2, 3


class DecayRegion:
    """The region |q| < `radius` of proven decay around an equilibrium.

    With separation the slider stays on one side of y = 0, where contact ends. `radius` is zero
    without a proof, such as for an unstable equilibrium. `unstable` is True if an eigenvalue has a
    positive real part beyond rounding; False for an equilibrium at y = 0, where eigenvalues do not
    decide. `growth` is the greatest real part of the eigenvalues, 1/s, and `fastest` their greatest
    modulus; `rest` is the equilibrium as a state.
    """

    def __init__(self, system: System, point: Equilibrium) -> None:
        p = system.parameters
        matrix = np.array(jacobian(p, point.y, point.mode))
        values, vectors = np.linalg.eig(matrix)
        self.growth = growth = float(values.real.max())
        self.fastest = float(np.abs(values).max())
        rounding = _ROUNDING * self.fastest
        self.unstable = growth > rounding and not is_on_edge(p, system.separation)
        self.radius = 0.0
        self.rest = np.array([point.x, 0.0, point.y, 0.0])
        self._modal = np.zeros((4, 4), dtype=complex)
        if growth >= -rounding or np.linalg.cond(vectors) > _MAX_CONDITION:
            return
        # Maps a deviation to modal coordinates.
        self._modal = np.linalg.inv(vectors)
        # Bounds of the deviations of y and ẋ are these norms times |q|.
        y_norm = float(np.linalg.norm(vectors[_Y]))
        vx_norm = float(np.linalg.norm(vectors[_VX]))
        in_contact = point.mode in IN_CONTACT
        cubic_bound = self._force_gain_bound(p) * (p.k_nl if in_contact else 0.0) / p.m
        # The radius is the |q| that solves σ = linear |q| + quadratic |q|².
        linear = 3.0 * cubic_bound * abs(point.y) * y_norm**2
        quadratic = cubic_bound * y_norm**3
        if in_contact and p.v_belt is not None and depends_on_speed(p):
            friction_gain = float(np.linalg.norm(self._modal[:, _VX])) / p.m
            _, _, curvature = friction_derivatives(p, 0.0, 2)
            curvature_bound = 0.5 * friction_gain * abs(curvature) * vx_norm**2
            stiffness = tangent_stiffness(p, point.y)
            slope_bound = friction_gain * abs(friction_slope(p, abs(p.v_belt)))
            contact_force = abs(point.P)
            linear += curvature_bound * contact_force + slope_bound * stiffness * y_norm * vx_norm
            quadratic += curvature_bound * stiffness * y_norm
        # This form of the solution also holds where `quadratic` is zero.
        decay_rate = -growth
        denominator = linear + math.sqrt(linear * linear + 4.0 * quadratic * decay_rate)
        self.radius = 2.0 * decay_rate / denominator if denominator > 0.0 else math.inf
        if system.separation and y_norm > 0.0:
            self.radius = min(self.radius, abs(point.y) / y_norm)
        if in_contact and p.v_belt is not None and vx_norm > 0.0:
            self.radius = min(self.radius, abs(p.v_belt) / vx_norm)

    def _force_gain_bound(self, p: Parameters) -> float:
        # Upper bound of |b|: the rate of q by a contact force, divided by force over m.
        if p.v_belt is None or not depends_on_speed(p):
            mu = sliding_friction_ratio(p)
            return float(np.linalg.norm(self._modal @ np.array([0.0, mu, 0.0, 1.0])))
        horizontal, vertical = np.linalg.norm(self._modal[:, [_VX, _VY]], axis=0).tolist()
        greatest = max(friction_coefficient(p, speed) for speed in (0.0, 2.0 * abs(p.v_belt)))
        return float(greatest * horizontal + vertical)

    @property
    def offset(self) -> float:
        """Vertical displacement from rest, m, below which decay is proven; 0 without a proof."""
        return self.radius / float(np.linalg.norm(self._modal[:, _Y])) if self.radius > 0.0 else 0.0

    def contains_states(self, states: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the motion from each state, shape (n, 4), is proven to decay."""
        q = (states - self.rest) @ self._modal.T
        decays: NDArray[np.bool_] = np.linalg.norm(q, axis=1) < self.radius
        return decays

    def contains(self, state: State) -> bool:
        """Whether the motion from a state is proven to decay."""
        return bool(self.contains_states(np.array([state]))[0])

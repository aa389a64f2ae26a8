"""The numbers of a panel of a figure, computed from the scenes of its points or lines."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from fivtui.equilibrium import (
    CriticalMu,
    Stability,
    critical_mu as all_critical_mu,
    growth_rate,
    stability,
)
from fivtui.model import ComputationError, Parameters, System, equilibrium
from fivtui.scene import Scene
from fivtui.transient import Transient, finite_trajectory

from .amplitudes import Amplitude
from .data import FigureData
from .panels import SEPARATION, Kind, Panel

Columns = Mapping[str, ArrayLike]

# Relative distance below which two frequencies count as equal: double roots are no more accurate.
_MERGING_TOL: Final = 1e-6
# Kinds of panels that are computed from transients.
_TRANSIENT_KINDS: Final[Sequence[Kind]] = ("transient", "amplitude")


def _equilibria(scenes: Iterable[Scene]) -> Columns:
    """Equilibria (Eq. 6)."""
    points = [equilibrium(System(scene.parameters)) for scene in scenes]
    return {"x_e": [point.x for point in points], "y_e": [point.y for point in points]}


def _eigenvalues(scenes: Iterable[Scene]) -> Columns:
    """The two modes (Eq. 8), and the critical friction coefficient, the same for a whole line."""
    verdicts = [stability(scene.parameters, separation=False) for scene in scenes]
    lower, upper = np.array([modes(verdict) for verdict in verdicts]).T
    return {
        "omega_1": lower.imag,
        "omega_2": upper.imag,
        "sigma_1": lower.real,
        "sigma_2": upper.real,
        "mu_c": [_least_mu(verdict.critical_mu) for verdict in verdicts],
    }


def modes(verdict: Stability) -> tuple[complex, complex]:
    """The eigenvalues of positive imaginary part, 1/s, lower frequency first.

    If the frequencies have merged, the growing mode comes first.
    """
    # They are sorted by falling imaginary part; the first two have a positive one.
    upper, lower = (complex(value) for value in verdict.eigenvalues[:2])
    merged = upper.imag - lower.imag <= _MERGING_TOL * upper.imag
    return (upper, lower) if merged and upper.real > lower.real else (lower, upper)


def _critical(scenes: Iterable[Scene]) -> Columns:
    """Critical friction coefficients (Eq. 9)."""
    return {"mu_c": [critical_mu(scene.parameters) for scene in scenes]}


def critical_mu(p: Parameters) -> float:
    """The least μ_c; `ComputationError` if no friction destabilises the equilibrium."""
    return _least_mu(all_critical_mu(System(p, separation=False)))


def _least_mu(critical: Sequence[CriticalMu]) -> float:
    if not critical:
        raise ComputationError(
            "no friction coefficient destabilises the equilibrium",
            "use parameters that have a critical friction coefficient",
        )
    return min(crossing.mu for crossing in critical)


# Functions that compute the columns of panels without transients, by kind.
COLUMNS: Final[Mapping[Kind, Callable[[Iterable[Scene]], Columns]]] = {
    "equilibrium": _equilibria,
    "eigenvalues": _eigenvalues,
    "critical mu": _critical,
}


def amplitude_columns(scenes: Iterable[Scene], amplitudes: Sequence[Amplitude]) -> Columns:
    """Growth rates of the equilibria, and the fields of the amplitudes."""
    growth = [growth_rate(System(scene.parameters, separation=False)) for scene in scenes]
    names = [field.name for field in fields(Amplitude)]
    return {"growth_rate": growth} | {
        name: [getattr(amplitude, name) for amplitude in amplitudes] for name in names
    }


def motion_columns(panel: Panel, runs: Sequence[Transient]) -> Columns:
    """Case, time and the quantity that a panel shows."""
    motions = [finite_trajectory(run) for run in runs]
    sizes = [motion.t.size for motion in motions]
    return {
        SEPARATION: np.repeat([float(run.separation) for run in runs], sizes),
        "t": np.concatenate([motion.t for motion in motions]),
        panel.shown: np.concatenate([getattr(motion, panel.shown) for motion in motions]),
    }


def panel_data(panel: Panel, computed: Columns) -> FigureData:
    """The data of a panel: computed columns, after the coordinates of its points."""
    columns = {name: np.array(values, dtype=float) for name, values in computed.items()}
    if panel.kind != "transient":
        values = [_line_value(line.scene, panel.by) for line in panel.lines]
        coordinates = {
            panel.by: np.repeat(values, [len(line.values) for line in panel.lines]),
            panel.along: np.concatenate([line.values for line in panel.lines]),
        }
        columns = coordinates | columns
    scene = panel.lines[0].scene
    run = {"start": scene.start, "t_end": scene.t_end} if panel.kind in _TRANSIENT_KINDS else {}
    provenance = {"parameters": panel.fixed, **run, "choice": panel.choice}
    return FigureData(panel.key, panel.caption, panel.by, panel.along, columns, provenance)


def _line_value(scene: Scene, name: str) -> float:
    return float(scene.separation) if name == SEPARATION else getattr(scene.parameters, name)

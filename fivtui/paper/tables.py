"""The numbers of a panel, computed from its scenes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from fivtui.equilibrium import (
    CriticalMu,
    Stability,
    critical_mu as critical_mus,
    growth_rate,
    stability,
)
from fivtui.model import ComputationError, Parameters, System, equilibrium
from fivtui.scene import Scene
from fivtui.transient import Transient, trajectory_of

from .amplitudes import Amplitude
from .data import FigureData
from .families import SEPARATION, Panel

# Frequencies with a smaller relative distance have merged: double roots are no more accurate.
_MERGED: Final = 1e-6


def equilibrium_table(panel: Panel, scenes: Iterable[Scene]) -> FigureData:
    """Equilibria along a parameter (Eq. 6): columns of the two parameters, ``x_e`` and ``y_e``."""
    points = [equilibrium(System(scene.parameters)) for scene in scenes]
    return _data(panel, {"x_e": [p.x for p in points], "y_e": [p.y for p in points]})


def eigenvalue_table(panel: Panel, scenes: Iterable[Scene]) -> FigureData:
    """The two modes along a parameter: eigenvalues of positive imaginary part (Eq. 8).

    Columns are the two parameters, ``omega_1``, ``omega_2``, ``sigma_1``, ``sigma_2`` and ``mu_c``,
    which is the same for a whole line.
    """
    verdicts = [stability(scene.parameters) for scene in scenes]
    lower, upper = zip(*(modes(verdict) for verdict in verdicts), strict=True)
    columns = {
        "omega_1": [value.imag for value in lower],
        "omega_2": [value.imag for value in upper],
        "sigma_1": [value.real for value in lower],
        "sigma_2": [value.real for value in upper],
        "mu_c": [_least(verdict.critical_mu) for verdict in verdicts],
    }
    return _data(panel, columns)


def modes(verdict: Stability) -> tuple[complex, complex]:
    """The eigenvalues of positive imaginary part, 1/s, lower frequency first.

    Of merged frequencies the growing mode comes first.
    """
    upper, lower = (complex(value) for value in verdict.eigenvalues[:2])
    merged = upper.imag - lower.imag <= _MERGED * upper.imag
    return (upper, lower) if merged and upper.real > lower.real else (lower, upper)


def critical_table(panel: Panel, scenes: Iterable[Scene]) -> FigureData:
    """Critical friction coefficient ``mu_c`` along a parameter (Eq. 9)."""
    return _data(panel, {"mu_c": [critical_mu(scene.parameters) for scene in scenes]})


def critical_mu(p: Parameters) -> float:
    """The least μ_c; `ComputationError` if no friction destabilises the equilibrium."""
    return _least(critical_mus(System(p)))


def _least(found: Sequence[CriticalMu]) -> float:
    if not found:
        raise ComputationError(
            "no friction coefficient destabilises the equilibrium",
            "use parameters that have a critical friction coefficient",
        )
    return min(critical.mu for critical in found)


def amplitude_table(panel: Panel, amplitudes: Sequence[Amplitude]) -> FigureData:
    """Amplitudes along a parameter: case, parameter, growth rate, fields of `Amplitude`."""
    growth = [growth_rate(System(scene.parameters)) for scene in panel.scenes()]
    columns: dict[str, Sequence[float]] = {
        "growth_rate": growth,
        "y_peak": [a.y_peak for a in amplitudes],
        "y_half_range": [a.y_half_range for a in amplitudes],
        "separations": [a.separations for a in amplitudes],
        "separated_time": [a.separated_time for a in amplitudes],
    }
    scene = panel.lines[0].scene
    return _data(panel, columns, start=scene.start, t_end=scene.t_end)


def transient_table(panel: Panel, runs: Sequence[Transient]) -> FigureData:
    """One quantity over time: columns of the case, time and the quantity that the panel shows."""
    parts = [(run, trajectory_of(run)) for run in runs]
    columns = {
        SEPARATION: np.concatenate([np.full(t.t.size, float(run.separation)) for run, t in parts]),
        "t": np.concatenate([t.t for _, t in parts]),
        panel.shown: np.concatenate([getattr(t, panel.shown) for _, t in parts]),
    }
    scene = panel.lines[0].scene
    return FigureData(
        panel.key,
        panel.caption,
        SEPARATION,
        "t",
        columns,
        _provenance(panel, start=scene.start, t_end=scene.t_end),
    )


PLAIN_TABLES: Final[Mapping[str, Callable[[Panel, Iterable[Scene]], FigureData]]] = {
    "equilibrium": equilibrium_table,
    "eigenvalues": eigenvalue_table,
    "critical mu": critical_table,
}


def _data(panel: Panel, computed: Mapping[str, Sequence[float]], **shared: Any) -> FigureData:
    lines = panel.lines
    columns = {
        panel.by: np.repeat(
            [_value(line.scene, panel.by) for line in lines], [len(line.values) for line in lines]
        ),
        panel.along: np.concatenate([line.values for line in lines]),
    }
    columns |= {name: np.array(values, dtype=float) for name, values in computed.items()}
    return FigureData(
        panel.key,
        panel.caption,
        panel.by,
        panel.along,
        columns,
        _provenance(panel, **shared),
    )


def _value(scene: Scene, name: str) -> float:
    return float(scene.separation) if name == SEPARATION else getattr(scene.parameters, name)


def _provenance(panel: Panel, **shared: Any) -> dict[str, Any]:
    return {"parameters": panel.fixed, **shared, "choice": panel.choice}
